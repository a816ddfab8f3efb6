//! Files of other programs: points, transforms, device sets and surfaces.

use ::exchange::mesh::{self, Mesh, MeshFormat};
use ::exchange::{LengthUnit, PatientAxes, Said, fcsv, itk, markups, plus};
use geometry::{Marker, Point, Rigid, Tool};

use crate::Failure;

type Seeds = Result<Vec<Vec<u8>>, Failure>;

/// Everything is said, so that nothing ends for want of it.
const SAID: Said = Said {
    axes: None,
    unit: Some(LengthUnit::Millimetre),
};

/// `.mrk.json`, or `.fcsv` where it begins with `#`: what is read is what is written of it.
pub(crate) fn points(bytes: &[u8]) {
    if bytes.starts_with(b"#") {
        if let Ok(file) = fcsv::read(bytes, SAID)
            && let Ok(text) = fcsv::write(&file, PatientAxes::Ras)
        {
            let again = fcsv::read(text.as_bytes(), SAID).map(|again| again.points);
            assert_eq!(again, Ok(file.points), "what was written is not read");
        }
    } else if let Ok(file) = markups::read(bytes, SAID) {
        let text = markups::write(&file, PatientAxes::Ras);
        let points = |file: markups::Markups| file.markups.into_iter().map(|markup| markup.points).collect::<Vec<_>>();
        let again = markups::read(text.as_bytes(), SAID).map(points);
        assert_eq!(again.ok(), Some(points(file)), "what was written is not read");
    }
}

/// A transform of ITK, as text or HDF5.
pub(crate) fn transform(bytes: &[u8]) {
    match itk::read::<Marker, Tool>(bytes) {
        Err(error) => drop(error.to_string()),
        Ok(read) => {
            let again = itk::read::<Marker, Tool>(itk::write(&read.to_from_from).as_bytes());
            let again = again.map(|again| again.to_from_from);
            let at = |rigid: Rigid<Marker, Tool>| rigid * Point::new(100.0, -50.0, 200.0);
            // Numbers of up to 1e9, to a few last places.
            let near = again.is_ok_and(|again| at(again).distance(at(read.to_from_from)) < 1e-5);
            assert!(near, "what was written is not read at the same place");
        }
    }
}

/// A device set of PLUS; each of its transforms is asked for.
pub(crate) fn device_set(bytes: &[u8]) {
    match plus::read(bytes) {
        Err(error) => drop(error.to_string()),
        Ok(set) => {
            for one in &set.definitions {
                drop(
                    set.find::<Marker, Tool>(&one.from, &one.to)
                        .map_err(|error| error.to_string()),
                );
            }
            assert_eq!(
                plus::read(plus::write(&set).as_bytes()),
                Ok(set),
                "what was written is not read"
            );
        }
    }
}

/// A surface; the first byte is its format, the next says its axes.
pub(crate) fn surface(bytes: &[u8]) {
    let [format, axes, bytes @ ..] = bytes else { return };
    let format = MeshFormat::ALL[usize::from(*format) % MeshFormat::ALL.len()];
    let axes = PatientAxes::ALL.get(usize::from(*axes)).copied();
    match mesh::read(bytes, format, Said { axes, ..SAID }) {
        Err(error) => drop(error.to_string()),
        Ok(mesh) => {
            let whole = |corners: &[u32; 3]| corners.iter().all(|corner| (*corner as usize) < mesh.points.len());
            assert!(mesh.triangles.iter().all(whole), "a triangle without a corner");
            // STL has a precision of its own.
            if format != MeshFormat::Stl
                && let Ok(bytes) = mesh::write(&mesh, format, PatientAxes::Ras)
            {
                let said = Said { axes: None, ..SAID };
                assert_eq!(
                    mesh::read(&bytes, format, said),
                    Ok(mesh),
                    "what was written is not read"
                );
            }
        }
    }
}

pub(crate) fn points_seeds() -> Seeds {
    let row = "1,-33.5,4,50,0.5,0.5,0.5,0.5,1,1,0,\"a, b\",d,\r,2,0\n";
    let head = "# Markups fiducial file version = 5.2\n# CoordinateSystem = LPS\n";
    let columns = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";
    let json = r#"{"@schema": "markups-schema-v1.0.3.json#", "markups": [{"type": "Line", "coordinateSystem": "RAS", "coordinateUnits": ["mm",
        "UCUM", "millimeter"], "display": {"opacity": 0.5}, "controlPoints": [{"label": "a", "position": [1, 2, 30], "orientation": [-1, 0, 0,
        0, -1, 0, 0, 0, 1], "positionStatus": "defined"}, {"label": "b", "position": "", "positionStatus": "preview"}]}]}"#;
    Ok(vec![json.into(), format!("{head}{columns}{row}").into_bytes()])
}

pub(crate) fn transform_seeds() -> Seeds {
    let euler = "Transform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 4 5 6\nFixedParameters: 1 2 3 1\n";
    let versor = "Transform: VersorRigid3DTransform_double_3_3\nParameters: 0.1 0 0.2 4 5 6\nFixedParameters: 1 2 3\n";
    let head = "#Insight Transform File V1.0\n#Transform 0\n";
    Ok(vec![
        itk::write(&Rigid::<Marker, Tool>::identity()).into_bytes(),
        format!("{head}Transform: CompositeTransform_double_3_3\n{euler}{versor}").into_bytes(),
        include_bytes!("../../crates/exchange/tests/data/euler.h5").to_vec(),
    ])
}

pub(crate) fn device_set_seeds() -> Seeds {
    let one = plus::Definition::new("StylusTip", "Stylus", &Rigid::<Marker, Tool>::identity());
    let error = plus::Definition {
        error: Some(0.5),
        date: Some("today".to_owned()),
        ..plus::Definition::new("A&B", "C", &Rigid::<Marker, Tool>::identity())
    };
    let definitions = vec![one, error];
    Ok(vec![plus::write(&plus::DeviceSet { definitions }).into_bytes()])
}

pub(crate) fn surface_seeds() -> Seeds {
    let mesh = Mesh {
        points: [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]]
            .map(|[x, y, z]| Point::new(x, y, z))
            .to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let mut seeds = Vec::new();
    for (format, number) in MeshFormat::ALL.into_iter().zip(0_u8..) {
        seeds.push([&[number, 2][..], &mesh::write(&mesh, format, PatientAxes::Ras)?].concat());
    }
    let texts = [
        (
            0,
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\nendsolid\n",
        ),
        (
            1,
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n",
        ),
        (
            3,
            "# vtk DataFile Version 5.1\na\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 9 0 0 0 9 0\nPOLYGONS 2 3\nOFFSETS \
             vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n",
        ),
    ];
    seeds.extend(texts.map(|(number, text)| [&[number, 0][..], text.as_bytes()].concat()));
    Ok(seeds)
}
