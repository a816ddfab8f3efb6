//! Surfaces: every coding of every format, what a head may promise, what is refused and with which words.

use exchange::mesh::{self, Mesh, MeshFormat};
use exchange::{LengthUnit, PatientAxes, Said};
use geometry::Point;

const LPS: Said = Said {
    axes: Some(PatientAxes::Lps),
    unit: None,
};

/// Four corners, in numbers that 32 bits hold exactly.
const CORNERS: [[f64; 3]; 4] = [
    [-61.25, -38.5, 912.125],
    [40.0, -38.5, 912.125],
    [-61.25, 60.0, 912.125],
    [-61.25, -38.5, 1000.0],
];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn tetrahedron() -> Mesh {
    Mesh {
        points: CORNERS.map(|[x, y, z]| Point::new(x, y, z)).to_vec(),
        triangles: FACES.to_vec(),
    }
}

/// The corners of each triangle, in order.
fn corners(mesh: &Mesh) -> Vec<[[f64; 3]; 3]> {
    let corner = |place: u32| mesh.points[place as usize].mm();
    mesh.triangles.iter().map(|corners| corners.map(corner)).collect()
}

fn read(bytes: &[u8], format: MeshFormat) -> Mesh {
    mesh::read(bytes, format, LPS).unwrap_or_else(|error| panic!("{format:?}: {error}"))
}

fn refused(bytes: &[u8], format: MeshFormat, said: Said) -> String {
    let error = mesh::read(bytes, format, said).unwrap_err().to_string();
    assert!(error.len() < 400, "{error}");
    error
}

fn stl_text() -> String {
    let mut text = "solid by hand\n".to_owned();
    for face in FACES {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in face.map(|corner| CORNERS[corner as usize]) {
            text += &format!("  vertex {x:e} {y} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid by hand\n"
}

/// A file of PLY of single precision, whose faces come with colours and a list more.
fn ply(format: &str, is_big: bool) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment a, b\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         element face 4\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
    )
    .into_bytes();
    let is_text = format == "ascii";
    let put = |bytes: &mut Vec<u8>, number: &[u8], text: String| match (is_text, is_big) {
        (true, _) => bytes.extend(format!("{text} ").bytes()),
        (false, true) => bytes.extend(number.iter().rev()),
        (false, false) => bytes.extend(number),
    };
    for point in CORNERS {
        for x in point {
            put(&mut bytes, &(x as f32).to_le_bytes(), x.to_string());
        }
        // In binary that is a line's end to those who read text.
        put(&mut bytes, &[10], "10".to_owned());
    }
    for face in FACES {
        put(&mut bytes, &[3], "3".to_owned());
        for corner in face {
            put(&mut bytes, &corner.to_le_bytes(), corner.to_string());
        }
        put(&mut bytes, &[1], "1".to_owned());
        put(&mut bytes, &0.5_f32.to_le_bytes(), "0.5".to_owned());
    }
    bytes
}

#[test]
fn what_is_written_is_read_and_says_its_axes() {
    for format in MeshFormat::ALL {
        for axes in PatientAxes::ALL {
            let bytes = mesh::write(&tetrahedron(), format, axes).unwrap();
            let found = mesh::read(&bytes, format, Said::default()).unwrap();
            assert_eq!(corners(&found), corners(&tetrahedron()), "{format:?} {axes:?}");
            // With the other word it is the mirror, and with none it is refused.
            let other = if axes == PatientAxes::Lps { "RAS" } else { "LPS" };
            let lied = replaced(&bytes, &format!("SPACE={}", axes.name()), &format!("SPACE={other}"));
            let mirrored = mesh::read(&lied, format, Said::default()).unwrap();
            let turned = corners(&tetrahedron())
                .iter()
                .map(|three| three.map(|[x, y, z]| [-x, -y, z]))
                .collect::<Vec<_>>();
            assert_eq!(corners(&mirrored), turned, "{format:?} {axes:?}");
            let unsaid = replaced(&bytes, "SPACE=", "written");
            assert!(
                refused(&unsaid, format, Said::default())
                    .contains("does not say whether its coordinates are LPS or RAS")
            );
            let said = Said {
                axes: Some(axes),
                unit: None,
            };
            assert_eq!(
                corners(&mesh::read(&unsaid, format, said).unwrap()),
                corners(&tetrahedron())
            );
            let wrong = replaced(&bytes, "SPACE=", "SPACE=X");
            assert!(refused(&wrong, format, LPS).contains("the comment says SPACE=X"));
        }
    }
}

/// The same bytes with other words of the same length, or of one more.
fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = bytes
        .windows(from.len())
        .position(|window| window == from.as_bytes())
        .unwrap();
    let mut out = [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat();
    // The head of STL has 80 bytes whatever is in it.
    if bytes.len() > 84 && !bytes.starts_with(b"ply") && !bytes.starts_with(b"#") && to.len() > from.len() {
        out.remove(79);
    }
    out
}

#[test]
fn text_and_binary_of_others_are_read_alike() {
    assert_eq!(
        corners(&read(stl_text().as_bytes(), MeshFormat::Stl)),
        corners(&tetrahedron())
    );
    // Binary that begins as text does.
    let mut solid = mesh::write(&tetrahedron(), MeshFormat::Stl, PatientAxes::Lps).unwrap();
    solid[..6].copy_from_slice(b"solid ");
    assert_eq!(corners(&read(&solid, MeshFormat::Stl)), corners(&tetrahedron()));
    for (format, is_big) in [
        ("ascii", false),
        ("binary_little_endian", false),
        ("binary_big_endian", true),
    ] {
        assert_eq!(read(&ply(format, is_big), MeshFormat::Ply), tetrahedron(), "{format}");
    }
    let obj = "# by hand\nmtllib a.mtl\nv -61.25 -38.5 912.125 1 0 0\nv 40 -38.5 912.125\nv -61.25 60 912.125\nv -61.25 -38.5 1000\nvn 0 0 1\n\
               f 1//1 3//1 2//1\nf -4 -3 -1\ng a\nf 2/1/1 3/2/1 4/3/1\nf 3 1 4\n";
    assert_eq!(read(obj.as_bytes(), MeshFormat::Obj), tetrahedron());
    let square = "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nf 1 2 3 4\n";
    assert_eq!(
        read(square.as_bytes(), MeshFormat::Obj).triangles,
        [[0, 1, 2], [0, 2, 3]]
    );
}

/// What a comment says of the axes in other letters was passed over, and the other axes were taken when they were said: the mirror.
#[test]
fn axes_that_are_written_a_little_differently_are_not_overruled() {
    let obj = |comment: &str| format!("# {comment}\nv 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n").into_bytes();
    for comment in [
        "SPACE=RAS",
        "space=ras",
        "SPACE = RAS",
        "SPACE:RAS",
        "(SPACE=RAS)",
        "\"SPACE=RAS\"",
        "SPACE=\"RAS\"",
        "a,SPACE=RAS,b",
        "xSPACE=RAS",
        "Coordinates RAS",
        "exported along ras",
        "exported along Right-Anterior-Superior",
        "axes R A S",
    ] {
        let said = refused(&obj(comment), MeshFormat::Obj, LPS);
        assert!(said.contains("nothing was taken"), "{comment}: {said}");
        let ras = Said {
            axes: Some(PatientAxes::Ras),
            unit: None,
        };
        let found = mesh::read(&obj(comment), MeshFormat::Obj, ras).unwrap();
        assert_eq!(found.points[1], Point::new(-100.0, 0.0, 0.0), "{comment}");
    }
    for comment in ["SPACE=R", "SPACE=", "SPACE=LAS", "SPACE=RAS SPACE=LPS", "space: sRGB"] {
        let said = refused(&obj(comment), MeshFormat::Obj, LPS);
        assert!(said.contains("the comment says SPACE="), "{comment}: {said}");
    }
    for comment in ["colorspace: sRGB", "brasil", "from RAS to LPS"] {
        read(&obj(comment), MeshFormat::Obj);
    }
    let end = stl_text().replace("endsolid by hand", "endsolid SPACE=RAS");
    assert!(refused(end.as_bytes(), MeshFormat::Stl, LPS).contains("the file says RAS"));
}

/// It was read in mm whatever its comment said.
#[test]
fn a_unit_that_a_comment_says_is_not_overruled() {
    let obj = |comment: &str| format!("# {comment}\nv 0 0 0\nv 25 0 0\nv 0 10 0\nf 1 2 3\n").into_bytes();
    let mimics = |number: &str| format!("vertex coordinates are measured in units, where 1 unit = {number} mm");
    let second = |comment: &str, unit| {
        let axes = LPS.axes;
        let found = mesh::read(&obj(comment), MeshFormat::Obj, Said { axes, unit });
        found
            .map(|mesh| mesh.points[1].mm()[0])
            .map_err(|error| error.to_string())
    };
    let (mm, m) = (Some(LengthUnit::Millimetre), Some(LengthUnit::Metre));
    for comment in [
        &mimics("1.000000"),
        &mimics("1"),
        "units: mm",
        "File units = millimeters",
        "all units are mm",
        "UNIT=mm",
    ] {
        assert_eq!(second(comment, None), Ok(25.0), "{comment}");
        assert_eq!(second(comment, mm), Ok(25.0), "{comment}");
        assert!(
            second(comment, m).unwrap_err().contains("the file says mm"),
            "{comment}"
        );
    }
    // 25 m is beyond what is a patient.
    for comment in [&mimics("1000.000000"), "units = meters", "1 unit = 1 m"] {
        assert!(second(comment, None).unwrap_err().contains("25000 mm"), "{comment}");
        assert!(
            second(comment, mm).unwrap_err().contains("the file says m "),
            "{comment}"
        );
    }
    for comment in [
        &mimics("10.000000"),
        &mimics("25.4"),
        "unit: cm",
        "unit = 1000",
        "units: inch",
        "1 unit is 10 mm",
        "units in cm",
        "unit=",
    ] {
        for said in [None, mm, m] {
            let said = second(comment, said).unwrap_err();
            assert!(said.contains("a comment says the unit"), "{comment}: {said}");
        }
    }
    assert!(second("unit=mm unit=m", None).is_err());
    let metres = b"# 1 unit = 1000.000000 mm\nv 0 0 0\nv 0.3 0 0\nv 0.2 0.1 0\nf 1 2 3\n";
    let found = mesh::read(metres, MeshFormat::Obj, LPS).unwrap();
    assert_eq!(found.points[1], Point::new(300.0, 0.0, 0.0));
    // Words that say no unit.
    assert_eq!(second("with unit normals, a community mesh", None), Ok(25.0));
}

/// Centimetres were read as mm where no sign stands behind the word, and a frame that is neither LPS nor RAS as the one that was said.
#[test]
fn a_unit_a_scale_or_a_frame_in_other_words_is_not_overruled() {
    let obj = |comment: &str| format!("# {comment}\nv 0 0 0\nv 25 0 0\nv 0 10 0\nf 1 2 3\n").into_bytes();
    for (comment, words) in [
        ("unit cm", "the word \"cm\""),
        ("units cm", "the word \"cm\""),
        ("all in cm", "the word \"cm\""),
        ("(cm)", "the word \"cm\""),
        ("coordinates in inches", "the word \"inches\""),
        ("length unit m", "the word \"m\""),
        ("scale: 10 mm", "the unit \"scale 10 mm"),
        ("scale factor = 0.1", "the unit \"scale 0.1"),
        ("scaled by 10", "the unit \"scale 10"),
        ("scale 10", "the unit \"scale 10"),
        ("frame=scanner", "a comment says \"frame=scanner\""),
        ("coordinate system: LAS", "a comment says \"coordinate system: LAS\""),
        ("a; CoordinateSystem = 2", "a comment says \"CoordinateSystem = 2\""),
    ] {
        let said = refused(&obj(comment), MeshFormat::Obj, LPS);
        assert!(said.contains(words), "{comment}: {said}");
    }
    for comment in [
        "unit mm",
        "all in mm",
        "from cm to mm",
        "scale: 1",
        "grayscale: 8",
        "frame: LPS",
        "scale: linear",
    ] {
        read(&obj(comment), MeshFormat::Obj);
    }
    let head = "ply\nformat ascii 1.0\ncomment unit cm\n";
    let text = String::from_utf8(ply("ascii", false)).unwrap();
    let ply = text.replace("ply\nformat ascii 1.0\n", head);
    assert!(refused(ply.as_bytes(), MeshFormat::Ply, LPS).contains("the word \"cm\""));
}

/// Text in capitals was refused as a binary file of 1 414 677 846 triangles.
#[test]
fn text_in_capitals_is_text() {
    let text = stl_text().to_uppercase();
    assert_eq!(
        corners(&read(text.as_bytes(), MeshFormat::Stl)),
        corners(&tetrahedron())
    );
    let cut = &text[..text.len() / 2];
    assert!(refused(cut.as_bytes(), MeshFormat::Stl, LPS).contains("line "));
}

/// Files of VTK as version 4 and 5 have them, as text and as binary, most significant byte first.
fn vtk(version: &str, is_text: bool) -> Vec<u8> {
    let kind = if is_text { "ASCII" } else { "BINARY" };
    let mut bytes =
        format!("# vtk DataFile Version {version}\nby hand\n{kind}\nDATASET POLYDATA\nPOINTS 4 float\n").into_bytes();
    let put = |bytes: &mut Vec<u8>, four: [u8; 4], text: String| match is_text {
        true => bytes.extend(format!("{text} ").bytes()),
        false => bytes.extend(four),
    };
    for x in CORNERS.into_iter().flatten() {
        put(&mut bytes, (x as f32).to_be_bytes(), x.to_string());
    }
    let flat: Vec<u32> = FACES.into_iter().flatten().collect();
    match version.starts_with('5') {
        true => {
            bytes.extend(b"\nMETADATA\nINFORMATION 0\n\nPOLYGONS 5 12\nOFFSETS vtktypeint64\n");
            let mut eight = |number: u64| match is_text {
                true => bytes.extend(format!("{number} ").bytes()),
                false => bytes.extend(number.to_be_bytes()),
            };
            [0, 3, 6, 9, 12].into_iter().for_each(&mut eight);
            bytes.extend(b"\nCONNECTIVITY vtktypeint64\n");
            for number in flat {
                match is_text {
                    true => bytes.extend(format!("{number} ").bytes()),
                    false => bytes.extend(u64::from(number).to_be_bytes()),
                }
            }
        }
        false => {
            bytes.extend(b"\nVERTICES 1 2\n");
            put(&mut bytes, 1_u32.to_be_bytes(), "1".to_owned());
            put(&mut bytes, 0_u32.to_be_bytes(), "0".to_owned());
            bytes.extend(b"\nPOLYGONS 4 16\n");
            for face in FACES {
                for number in [3].into_iter().chain(face) {
                    put(&mut bytes, number.to_be_bytes(), number.to_string());
                }
            }
        }
    }
    bytes.extend(b"\nPOINT_DATA 4\nNORMALS Normals float\n");
    bytes
}

#[test]
fn legacy_vtk_of_both_generations_is_read() {
    for version in ["2.0", "3.0", "4.2", "5.1"] {
        for is_text in [true, false] {
            assert_eq!(
                read(&vtk(version, is_text), MeshFormat::Vtk),
                tetrahedron(),
                "{version} {is_text}"
            );
        }
    }
    let strips = String::from_utf8(vtk("3.0", true))
        .unwrap()
        .replace("POLYGONS", "TRIANGLE_STRIPS");
    assert!(refused(strips.as_bytes(), MeshFormat::Vtk, LPS).contains("strips of triangles is not read; save"));
    let grid = String::from_utf8(vtk("3.0", true))
        .unwrap()
        .replace("POLYDATA", "UNSTRUCTURED_GRID");
    assert!(refused(grid.as_bytes(), MeshFormat::Vtk, LPS).contains("expected POLYDATA"));
}

/// Corners as numbers with fractions were taken for 0, and the surface was gone.
#[test]
fn corners_that_are_no_whole_numbers_are_refused() {
    let of = |kind: &str| {
        let text = String::from_utf8(ply("ascii", false)).unwrap();
        text.replace(
            "list uchar int vertex_indices",
            &format!("list uchar {kind} vertex_indices"),
        )
    };
    for kind in ["float", "double"] {
        let said = refused(of(kind).as_bytes(), MeshFormat::Ply, LPS);
        assert!(
            said.contains("vertex_indices of numbers with fractions\"; expected whole"),
            "{said}"
        );
    }
    assert_eq!(read(of("uint").as_bytes(), MeshFormat::Ply), tetrahedron());
}

/// Another list may hold what is no corner.
#[test]
fn lists_that_are_no_corners_hold_any_number() {
    let text = String::from_utf8(ply("ascii", false)).unwrap();
    let text = text
        .replace("list uchar float texcoord", "list uchar int flags")
        .replace(" 1 0.5", " 1 -1");
    assert_eq!(read(text.as_bytes(), MeshFormat::Ply), tetrahedron());
}

/// Triangles before the first place or behind the last were lost.
#[test]
fn places_of_polygons_that_leave_some_out_are_refused() {
    let good = String::from_utf8(vtk("5.1", true)).unwrap();
    assert!(good.contains("POLYGONS 5 12") && good.contains("\n0 3 6 9 12 \n"));
    for (count, places) in [
        ("4", "3 6 9 12"),
        ("4", "0 3 6 9"),
        ("5", "0 3 6 9 11"),
        ("5", "1 3 6 9 12"),
        ("2", "0 3"),
    ] {
        let text = good
            .replace("POLYGONS 5 12", &format!("POLYGONS {count} 12"))
            .replace("\n0 3 6 9 12 \n", &format!("\n{places} \n"));
        let said = refused(text.as_bytes(), MeshFormat::Vtk, LPS);
        assert!(said.contains("expected all of them, from 0 to 12"), "{places}: {said}");
    }
    let back = good.replace("\n0 3 6 9 12 \n", "\n0 6 3 9 12 \n");
    assert!(refused(back.as_bytes(), MeshFormat::Vtk, LPS).contains("polygon 2"));
}

/// Such a file was said to have no triangle.
#[test]
fn what_a_file_of_vtk_carries_before_its_points_is_read_over() {
    for (version, field) in [
        ("3.0", "FIELD FieldData 2\na 1 1 float\n5\nb 2 2 double\n1 2 3 4\n"),
        ("5.1", "FIELD FieldData 1\na 1 1 float\n5\nMETADATA\nINFORMATION 0\n\n"),
    ] {
        let text = String::from_utf8(vtk(version, true)).unwrap();
        let text = text.replace("POINTS", &format!("{field}POINTS"));
        assert_eq!(read(text.as_bytes(), MeshFormat::Vtk), tetrahedron(), "{version}");
    }
    let text = String::from_utf8(vtk("3.0", true)).unwrap();
    let twice = text.replace("POLYGONS", "POINTS 1 float\n900 0 0\nPOLYGONS");
    assert!(refused(twice.as_bytes(), MeshFormat::Vtk, LPS).contains("expected the points once"));
    let lies = text.replace("POINTS", "FIELD FieldData 1\na 5000000 9 float\n1\nPOINTS");
    assert!(refused(lies.as_bytes(), MeshFormat::Vtk, LPS).contains("an array: 89999999 bytes are promised"));
}

/// Heads that promise more than ten gigabytes, before a byte is held for them; and the same of each count that is read.
#[test]
fn a_head_that_lies_is_refused_by_the_bytes_that_are_there() {
    let ply = |count: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty double x\nproperty double y\nproperty double z\nend_header\nabc"
        )
    };
    let text = |count: &str| ply(count).replace("binary_little_endian", "ascii");
    let points = |kind: &str, count: &str| {
        format!("# vtk DataFile Version 3.0\na\n{kind}\nDATASET POLYDATA\nPOINTS {count} double\n1 2 3\n")
    };
    let mut stl = vec![b' '; 200];
    stl[80..84].copy_from_slice(&40_000_000_u32.to_le_bytes());
    for (bytes, format, words) in [
        (
            ply("45000000").into_bytes(),
            MeshFormat::Ply,
            "1080000000 bytes are promised and 3 are left",
        ),
        (
            ply("18446744073709551615").into_bytes(),
            MeshFormat::Ply,
            "18446744073709551615 elements; at most",
        ),
        (
            ply("99999999999999999999").into_bytes(),
            MeshFormat::Ply,
            "expected how many there are",
        ),
        (ply("-1").into_bytes(), MeshFormat::Ply, "expected how many there are"),
        (text("45000000").into_bytes(), MeshFormat::Ply, "are promised and"),
        (
            points("BINARY", "45000000").into_bytes(),
            MeshFormat::Vtk,
            "1080000000 bytes are promised and 6 are left",
        ),
        (
            points("ASCII", "45000000").into_bytes(),
            MeshFormat::Vtk,
            "the points: 269999999 bytes are promised",
        ),
        (
            points("ASCII", "500000000000").into_bytes(),
            MeshFormat::Vtk,
            "500000000000 points; at most",
        ),
        (stl, MeshFormat::Stl, "2000000000 bytes are promised and 116 are left"),
    ] {
        let said = refused(&bytes, format, LPS);
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn what_cannot_be_right_is_refused_by_name() {
    let obj = |lines: &str| format!("v 0 0 0\nv 100 0 0\nv 0 100 0\n{lines}").into_bytes();
    let small = b"v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n";
    for (bytes, words) in [
        (
            obj("f 1 2 4"),
            "triangle 1 has the corners [0, 1, 3]; there are 3 points",
        ),
        (obj("f 0 1 2"), "from 1 or back from -1"),
        (obj("f -4 1 2"), "back from -1"),
        (obj("f 1 2"), "polygon 1 has 2 corners"),
        (obj("v nan 0 0\nf 1 2 3"), "point 4 is [NaN, 0.0, 0.0]"),
        (obj("v inf 0 0\nf 1 2 3"), "point 4"),
        (obj("v 1 2\nf 1 2 3"), "line 4: \"v 1 2\"; expected v and three numbers"),
        (obj("curv 1 2\nf 1 2 3"), "line 4"),
        (obj(""), "there is no triangle"),
        (obj("v 1e7 0 0\nf 1 2 3"), "the unit cannot be right"),
        (
            small.to_vec(),
            "the longest side of the surface is 0.1 in the file's numbers: that looks like metres",
        ),
        (Vec::new(), "there is no triangle"),
        (b"\x00\xff".to_vec(), "line 1"),
    ] {
        let said = refused(&bytes, MeshFormat::Obj, LPS);
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = Said {
        unit: Some(LengthUnit::Metre),
        ..LPS
    };
    let metres = mesh::read(small, MeshFormat::Obj, said).unwrap();
    assert_eq!(metres.points[1], Point::new(100.0, 0.0, 0.0));
    let stl = stl_text();
    for (text, words) in [
        (stl.replace("endsolid by hand", ""), "cut off"),
        (stl.replacen("vertex", "vertx", 1), "line 4: \"vertx\"; expected vertex"),
        (stl.clone() + &stl, "one solid is read"),
        (stl.replacen("-38.5", "x", 1), "expected a coordinate"),
        ("anything".to_owned(), "the head of a binary STL"),
    ] {
        let said = refused(text.as_bytes(), MeshFormat::Stl, LPS);
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// Each format cut off at every place, and each of its bytes another one.
#[test]
fn damage_is_refused_or_read_and_never_more() {
    let files = [
        (stl_text().into_bytes(), MeshFormat::Stl),
        (
            mesh::write(&tetrahedron(), MeshFormat::Stl, PatientAxes::Ras).unwrap(),
            MeshFormat::Stl,
        ),
        (ply("ascii", false), MeshFormat::Ply),
        (ply("binary_big_endian", true), MeshFormat::Ply),
        (
            mesh::write(&tetrahedron(), MeshFormat::Obj, PatientAxes::Ras).unwrap(),
            MeshFormat::Obj,
        ),
        (vtk("4.2", false), MeshFormat::Vtk),
        (vtk("5.1", true), MeshFormat::Vtk),
        (vtk("5.1", false), MeshFormat::Vtk),
    ];
    for (good, format) in files {
        for place in 0..good.len() {
            let _ = mesh::read(&good[..place], format, LPS);
            for value in [0, 0xff, b'9', good[place] ^ 0x10] {
                let mut bytes = good.clone();
                bytes[place] = value;
                let _ = mesh::read(&bytes, format, LPS);
            }
        }
    }
}
