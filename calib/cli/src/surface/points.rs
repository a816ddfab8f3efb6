//! Points of the bone's surface as a file has them, with their errors.

use std::path::Path;

use geometry::{Frame, Image, Marker, Point, Rigid, Tool, Uncertain, checked};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3};
use surface_registration::{Beam, BeamNoise, Points, SharedError, SurfacePoint};

use super::error::SurfaceCommandError;
use super::mirror::{self, Sounded};
use crate::input_files::columns::{Layout, Row, Table, TableError};
use crate::input_files::points_text::{COVARIANCE, SHARED};
use crate::input_files::source::Source;
use crate::live::shared as touches_shared;
use crate::register::solve::From;

const BEAM: [&str; 3] = ["beam_x", "beam_y", "beam_z"];
const ACROSS: [&str; 3] = ["across_x", "across_y", "across_z"];
const NOISE: [&str; 3] = ["axial", "lateral", "elevation"];
const TURN: [&str; 4] = ["marker_qw", "marker_qx", "marker_qy", "marker_qz"];
const SHIFT: [&str; 3] = ["marker_x", "marker_y", "marker_z"];

const LAYOUT: Layout = Layout {
    needed: &["x", "y", "z"],
    optional: &[
        &["on"],
        &["sigma"],
        &COVARIANCE,
        &SHARED,
        &NOISE,
        &BEAM,
        &ACROSS,
        &["depth"],
        &[
            "marker_qw",
            "marker_qx",
            "marker_qy",
            "marker_qz",
            "marker_x",
            "marker_y",
            "marker_z",
        ],
    ],
    hint: "x,y,z and, where they are known, on, sigma or cxx,cxy,cxz,cyy,cyz,czz or axial,lateral,elevation, \
           beam_x,beam_y,beam_z, across_x,across_y,across_z, depth, marker_qw,marker_qx,marker_qy,marker_qz,marker_x,marker_y,marker_z",
};

/// How far the tip may lie from the point that a marker's pose was written beside, mm: poses beyond are another tool's.
const OFF_TIP_MM: f64 = 2.0;
/// Quaternions and directions of files have six digits at least.
const UNIT_TOLERANCE: f64 = 1e-5;

/// Points that were read.
pub(super) struct Measured {
    pub(super) points: Points<From>,
    pub(super) lines: Vec<usize>,
    pub(super) labels: Vec<String>,
    pub(super) shared: Shared,
    /// The same points as they lie if their images were mirrored, where a probe saw them and it is known about which column that would be.
    pub(super) mirrored: Option<Points<From>>,
}

/// What is known of the error that all points share.
#[derive(Debug, Clone)]
pub(super) enum Shared {
    /// Nothing was told.
    Unknown,
    /// The file of touches tells it, point by point (`u1x` to `u3z`).
    Touches,
    /// A shift of all of them, of this deviation along each axis, mm.
    Shift(f64),
    /// That of a calibration of the tip, named in words.
    Tip(String, Box<Uncertain<Marker, Tool>>),
    /// That of a calibration of an ultrasound probe, named in words, and the column about which a scanner mirrors its images, mm.
    Probe(String, Box<Uncertain<Marker, Image>>, Option<f64>),
}

/// How points are to be taken where their file leaves it open.
pub(super) struct Asked<'a> {
    pub(super) path: &'a Path,
    /// Deviation along each axis of points whose file has none, mm.
    pub(super) noise_mm: Option<f64>,
    /// Points nearer to one another count as one, mm.
    pub(super) held_mm: f64,
    pub(super) shared: Shared,
}

impl Measured {
    /// Reads points.
    pub(super) fn read(source: &Source, asked: Asked<'_>) -> Result<Self, SurfaceCommandError> {
        let table = Table::new(source, &LAYOUT)?;
        let told = of_touches(&table, &asked)?;
        let of = Of::table(&table, &asked)?;
        let rows = table.rows(&LAYOUT)?;
        let points = rows.iter().map(|row| of.point(row)).collect::<Result<Vec<_>, _>>()?;
        let lines: Vec<usize> = rows.iter().map(|row| row.line).collect();
        let mut mirrored = None;
        let shared = match &told {
            Shared::Unknown => None,
            Shared::Touches => Some(stated(&rows)?),
            Shared::Shift(sigma_mm) => Some(shift(*sigma_mm, points.len())),
            Shared::Tip(of, tip) => {
                let at = tip.transform() * Point::new(0.0, 0.0, 0.0);
                let off = |place: Point<Marker>| place.distance(at);
                Some(of_tool((of, tip, "the tip"), off, &table, &rows, &points, asked.path)?.0)
            }
            Shared::Probe(of, image, axis_mm) => {
                let back = image.transform().inverse();
                // The image is a plane.
                let off = |place: Point<Marker>| (back * place).mm()[2].abs();
                let of = (of.as_str(), image.as_ref(), "the image");
                let (shared, poses) = of_tool(of, off, &table, &rows, &points, asked.path)?;
                // Places that are no cloud once they are mirrored say nothing of the file: that it was not looked at is told.
                mirrored = axis_mm.and_then(|axis_mm| {
                    let sounded = Sounded {
                        points: &points,
                        poses: &poses,
                        marker_from_image: image.transform(),
                        axis_mm,
                    };
                    mirror::points(&sounded, image.covariance(), asked.held_mm).ok()
                });
                Some(shared)
            }
        };
        let labels = rows.iter().map(|row| row.text("on").to_owned()).collect();
        let points = Points::new(&points, shared, asked.held_mm)
            .map_err(|source| SurfaceCommandError::points(asked.path, &lines, source))?;
        Ok(Self {
            points,
            lines,
            labels,
            shared: told,
            mirrored,
        })
    }
}

/// How the errors of a file's points are told.
struct Of {
    noise: NoiseOf,
    has_beam: bool,
    has_across: bool,
    has_depth: bool,
    has_shared: bool,
}

enum NoiseOf {
    Told(f64),
    Sigma,
    Covariance,
    Beam,
}

impl Of {
    fn table(table: &Table<'_>, asked: &Asked<'_>) -> Result<Self, SurfaceCommandError> {
        let wrong = |what| SurfaceCommandError::Columns {
            path: asked.path.to_owned(),
            what,
        };
        let kinds = [table.has("sigma"), table.has("cxx"), table.has("axial")];
        let noise = match (kinds, asked.noise_mm) {
            ([true, false, false], None) => NoiseOf::Sigma,
            ([false, true, false], None) => NoiseOf::Covariance,
            ([false, false, true], None) => NoiseOf::Beam,
            ([false, false, false], Some(noise_mm)) => NoiseOf::Told(noise_mm),
            ([false, false, false], None) => {
                return Err(wrong(
                    "it has no errors of its points (sigma, cxx... or axial,lateral,elevation): say --noise-mm",
                ));
            }
            (_, Some(_)) => return Err(wrong("it has the errors of its points: --noise-mm would overrule them")),
            _ => return Err(wrong("it has the errors of its points in more than one way")),
        };
        let of = Self {
            noise,
            has_beam: table.has("beam_x"),
            has_across: table.has("across_x"),
            has_depth: table.has("depth"),
            has_shared: table.has(SHARED[0]),
        };
        if !of.has_beam && (of.has_depth || of.has_across || matches!(of.noise, NoiseOf::Beam)) {
            return Err(wrong(
                "depth, across and axial,lateral,elevation are of a beam: the columns beam_x,beam_y,beam_z are missing",
            ));
        }
        Ok(of)
    }

    fn point(&self, row: &Row<'_>) -> Result<SurfacePoint<From>, TableError> {
        let [x, y, z] = row.point(["x", "y", "z"])?;
        let place = Point::new(x, y, z);
        let beam = match self.has_beam {
            true => Some(self.beam(row)?),
            false => None,
        };
        let even = |sigma_mm: f64| Matrix3::identity() * (sigma_mm * sigma_mm);
        let covariance_mm2 = match (&self.noise, beam) {
            (NoiseOf::Told(sigma_mm), _) => even(*sigma_mm),
            (NoiseOf::Sigma, _) => even(deviation(row, "sigma")?),
            (NoiseOf::Covariance, _) if self.has_shared => own(row)?,
            (NoiseOf::Covariance, _) => covariance(row)?,
            (NoiseOf::Beam, Some(beam)) => return self.seen(row, place, beam),
            // Refused with the header.
            (NoiseOf::Beam, None) => Matrix3::repeat(f64::NAN),
        };
        Ok(SurfacePoint {
            place,
            covariance_mm2,
            beam,
        })
    }

    fn beam(&self, row: &Row<'_>) -> Result<Beam<From>, TableError> {
        let depth = match self.has_depth && !row.text("depth").trim().is_empty() {
            true => Some(row.number("depth")?),
            false => None,
        };
        Ok(Beam {
            direction: unit(row, BEAM)?,
            depth_mm: depth,
        })
    }

    fn seen(&self, row: &Row<'_>, place: Point<From>, beam: Beam<From>) -> Result<SurfacePoint<From>, TableError> {
        let [axial, lateral, elevation] = NOISE;
        let (axial_mm, lateral_mm) = (deviation(row, axial)?, deviation(row, lateral)?);
        let elevation_mm = deviation(row, elevation)?;
        let noise = BeamNoise {
            axial_mm,
            lateral_mm,
            elevation_mm,
        };
        let across = match self.has_across {
            true => unit(row, ACROSS)?,
            // Whichever it is where the two are alike.
            false if lateral_mm == elevation_mm => {
                across(beam.direction.components()).ok_or_else(|| row.bad("beam_x", "a direction of length 1"))?
            }
            false => {
                return Err(row.bad(
                    "lateral",
                    "what elevation is, or the columns across_x,across_y,across_z, which tell the two apart",
                ));
            }
        };
        Ok(SurfacePoint::seen(place, beam, across, noise))
    }
}

/// A deviation: its square is one for either sign.
fn deviation(row: &Row<'_>, name: &str) -> Result<f64, TableError> {
    let mm = row.number(name)?;
    match mm > 0.0 {
        true => Ok(mm),
        false => Err(row.bad(name, "a deviation above 0 mm")),
    }
}

/// A direction of length 1, to the digits that files have.
fn unit(row: &Row<'_>, names: [&str; 3]) -> Result<geometry::Direction<From>, TableError> {
    let v = row.point(names)?;
    let length = Vector3::from(v).norm();
    let bad = || row.bad(names[0], format!("a direction of length 1; its length is {length:.6}"));
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        return Err(bad());
    }
    checked::direction(v).map_err(|_| bad())
}

/// A direction square to another one.
fn across(beam: [f64; 3]) -> Option<geometry::Direction<From>> {
    let beam = Vector3::from(beam);
    let axis = [Vector3::x(), Vector3::y(), Vector3::z()][beam.iamin()];
    checked::direction(beam.cross(&axis).into()).ok()
}

fn covariance(row: &Row<'_>) -> Result<Matrix3<f64>, TableError> {
    let mut entries = [0.0; 6];
    for (entry, name) in entries.iter_mut().zip(COVARIANCE) {
        *entry = row.number(name)?;
    }
    let [xx, xy, xz, yy, yz, zz] = entries;
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

/// What is a touch's own: the rest is told apart.
fn own(row: &Row<'_>) -> Result<Matrix3<f64>, TableError> {
    let shared = touches_shared(row)?;
    let own = covariance(row)? - shared * shared.transpose();
    // The point would be refused as well, by numbers that the file does not have.
    match own.symmetric_eigenvalues().min() > 0.0 {
        true => Ok(own),
        false => Err(row.bad(COVARIANCE[0], "a covariance that is more than u1x to u3z make of it")),
    }
}

/// Where the shared error is from: as is told, else from the columns of touches where they are there.
fn of_touches(table: &Table<'_>, asked: &Asked<'_>) -> Result<Shared, SurfaceCommandError> {
    let wrong = |what| SurfaceCommandError::Columns {
        path: asked.path.to_owned(),
        what,
    };
    match (&asked.shared, table.has(SHARED[0])) {
        (_, true) if !table.has(COVARIANCE[0]) => {
            Err(wrong("u1x to u3z are a part of a covariance: cxx to czz are missing"))
        }
        (Shared::Shift(_), true) => Err(wrong(
            "it has what its points share (u1x to u3z): --shared-mm would overrule it",
        )),
        (Shared::Unknown, true) => Ok(Shared::Touches),
        (told, _) => Ok(told.clone()),
    }
}

/// The shared error of the columns of touches: three numbers of deviation 1, which move each point by its own columns.
fn stated(rows: &[Row<'_>]) -> Result<SharedError, TableError> {
    let lever = |row: &Row<'_>| {
        let mut lever = Matrix3x6::zeros();
        lever.fixed_view_mut::<3, 3>(0, 0).copy_from(&touches_shared(row)?);
        Ok(lever)
    };
    let mut covariance = Matrix6::zeros();
    for k in 0..3 {
        covariance[(k, k)] = 1.0;
    }
    Ok(SharedError {
        covariance,
        levers: rows.iter().map(lever).collect::<Result<_, TableError>>()?,
    })
}

/// A shift of all points together.
fn shift(sigma_mm: f64, points: usize) -> SharedError {
    let mut covariance = Matrix6::zeros();
    let mut lever = Matrix3x6::zeros();
    for axis in 0..3 {
        covariance[(3 + axis, 3 + axis)] = sigma_mm * sigma_mm;
        lever[(axis, 3 + axis)] = 1.0;
    }
    SharedError {
        covariance,
        levers: vec![lever; points],
    }
}

/// The error of a tool's calibration (a tip's, a probe's), which every point has by the pose of the marker as it was taken. `off` says by how
/// much a place in the marker contradicts the calibration, mm, of what it speaks in `what`: points beyond are another tool's. The poses come with it.
fn of_tool<T: Frame>(
    (of, tool, what): (&str, &Uncertain<Marker, T>, &str),
    off: impl Fn(Point<Marker>) -> f64,
    table: &Table<'_>,
    rows: &[Row<'_>],
    points: &[SurfacePoint<From>],
    path: &Path,
) -> Result<(SharedError, Vec<Rigid<From, Marker>>), SurfaceCommandError> {
    if !table.has(TURN[0]) {
        return Err(SurfaceCommandError::NoMarkerPoses { path: path.to_owned() });
    }
    if tool.upper().iter().all(|entry| *entry == 0.0) {
        return Err(SurfaceCommandError::NoCovariance { of: of.to_owned() });
    }
    let (mut poses, mut places) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
    for (row, point) in rows.iter().zip(points) {
        let pose = marker_pose(row)?;
        let place = pose.inverse() * point.place;
        let off_mm = off(place);
        if off_mm.is_nan() || off_mm > OFF_TIP_MM {
            let expected = format!(
                "a pose of the marker that puts {what} within {OFF_TIP_MM} mm of the point; it is {off_mm:.1} mm off"
            );
            return Err(row.bad(SHIFT[0], expected).into());
        }
        poses.push(pose);
        places.push(place);
    }
    Ok((SharedError::of_tool(tool.covariance(), &poses, &places), poses))
}

fn marker_pose(row: &Row<'_>) -> Result<Rigid<From, Marker>, TableError> {
    let mut turn = [0.0; 4];
    for (part, name) in turn.iter_mut().zip(TURN) {
        *part = row.number(name)?;
    }
    checked::rigid(turn, row.point(SHIFT)?, UNIT_TOLERANCE).map_err(|_| row.bad(TURN[0], "a quaternion of length 1"))
}
