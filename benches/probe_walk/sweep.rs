//! A probe that glides over a patient's skin, and the bone in its images.

use bus::clock::monotonic_ns;
use chance::Chance;
use echo::bone::{BoneLine, BonePoint, Options, find};
use geometry::{Ct, Direction, Image, Point, Probe, Rigid, Tool, Tracker, Vector, checked};
use nalgebra::Matrix6;
use phantom::Phantom;
use scene::operating_room::{Array, Probe as Spec};
use surface_registration::{Beam, BeamNoise, Points, SharedError, SurfacePoint};
use tracker_proc::probe::SimulatedProbe;
use ultrasound::Image as UsImage;

/// Every so many-th place of the hand.
const EVERY: usize = 3;
/// Points that are nearer to one another count as one: they share the pose of their image and the look of their echo, mm.
const HELD_MM: f64 = 8.0;
/// Points of one image are taken so far from one another, mm.
const STEP_MM: f64 = 3.0;
/// A point that is so far from the true bone is no error of its place, mm.
const FAR_MM: f64 = 3.0;
/// From here on it is bone, HU, as the simulated scanner has it.
const BONE_HU: f64 = 300.0;
/// Deviation of a point across the image: of the beam's height, mm.
const ELEVATION_MM: f64 = 0.7;
/// Deviations of the marker's poses along and about each axis.
const POSE: [f64; 2] = [0.1, 0.0005];
/// Those of the probe's calibration: mm and rad.
const CALIBRATION: [f64; 2] = [0.2, 0.003];
/// Deviation of the speed of sound.
const SPEED: f64 = 0.015;

/// A sweep to come.
pub(crate) struct Sweep<'a> {
    patient: &'a Phantom,
    places: Vec<Rigid<Ct, Tool>>,
    probe: SimulatedProbe,
    chance: Chance,
    seed: u64,
    speed: f64,
}

/// What a sweep gave.
pub(crate) struct Swept {
    pub(crate) points: Points<Tracker>,
    /// The same as the scanner would have shown them mirrored.
    pub(crate) mirrored: Points<Tracker>,
    pub(crate) tracker_from_ct: Rigid<Tracker, Ct>,
    pub(crate) images: usize,
    pub(crate) with_bone: usize,
    /// Of the points from the true bone along their beams: bias, scatter, and the deviation told, mm; of those that are not far.
    pub(crate) off_mm: [f64; 3],
    /// Share of the points that are 3 mm and more from the true bone.
    pub(crate) far: f64,
    /// True speed over the nominal one.
    pub(crate) speed: f64,
    /// To make the images, and to find bone in them, each, s.
    pub(crate) seconds: [f64; 2],
}

/// A small motion of these deviations along and about each axis.
fn small<A: geometry::Frame, B: geometry::Frame>([mm, rad]: [f64; 2], chance: &Chance, first: u64) -> Rigid<A, B> {
    let normal = |i: u64| chance.normal(first + i);
    let turn = Vector::new(rad * normal(0), rad * normal(1), rad * normal(2));
    Rigid::from_rotation_vector(turn, Vector::new(mm * normal(3), mm * normal(4), mm * normal(5))).unwrap()
}

impl<'a> Sweep<'a> {
    pub(crate) fn of(patient: &'a Phantom, seed: u64, images: usize) -> Self {
        let chance = Chance::new(seed, 0);
        let speed = 1.0 + SPEED * chance.normal(50);
        let spec = Spec {
            array: Array::Convex {
                radius_mm: 60.0,
                half_angle_rad: 0.5,
            },
            depth_mm: 80.0,
            pixel_mm: 0.25,
            rate_hz: 15.0,
            lag_s: 0.0,
            speed_ratio: speed,
        };
        Self {
            patient,
            places: crate::sounding::places(patient, seed)
                .into_iter()
                .step_by(EVERY)
                .take(images)
                .collect(),
            probe: SimulatedProbe::new(spec, seed).unwrap(),
            chance,
            seed,
            speed,
        }
    }

    pub(crate) fn go(mut self, pictures: Option<&str>) -> Swept {
        let turn = Vector::new(0.4, -1.1, 0.8);
        let tracker_from_ct: Rigid<Tracker, Ct> =
            Rigid::from_rotation_vector(turn, Vector::new(150.0, -80.0, 1200.0)).unwrap();
        // The marker sits somewhere on the probe; its calibration is wrong by what is told of it.
        let turn = Vector::new(1.2, 0.1, -0.4);
        let probe_from_tool: Rigid<Probe, Tool> =
            Rigid::from_rotation_vector(turn, Vector::new(30.0, 45.0, -110.0)).unwrap();
        let true_image: Rigid<Probe, Image> = probe_from_tool * self.probe.image_on_tool().unwrap();
        let told_image = small::<Probe, Probe>(CALIBRATION, &self.chance, 60) * true_image;
        let (mut taken, mut turned, mut offs, mut with_bone, mut seconds) =
            (Vec::new(), Vec::new(), Vec::new(), 0, [0.0; 2]);
        for (number, place) in (0..).zip(self.places.clone()) {
            let line = self.look(place, number, (pictures, &mut seconds));
            with_bone += usize::from(!line.points.is_empty());
            let draw = Chance::new(self.seed, 1000 + number);
            let pose = tracker_from_ct * place * probe_from_tool.inverse() * small::<Probe, Probe>(POSE, &draw, 0);
            for point in apart(&line) {
                taken.push(seen(point, pose, told_image));
                turned.push(seen(&mirrored(point, self.probe.shape()), pose, told_image));
                offs.push([self.off_mm(point, place), point.axial_mm]);
            }
        }
        let images = self.places.len();
        Swept {
            points: points(&taken),
            mirrored: points(&turned),
            tracker_from_ct,
            images,
            with_bone,
            far: offs.iter().filter(|[off, _]| off.abs() >= FAR_MM).count() as f64 / offs.len() as f64,
            off_mm: near(&offs),
            speed: self.speed,
            seconds: seconds.map(|s| s / images as f64),
        }
    }

    /// Makes an image and finds bone in it.
    fn look(
        &mut self,
        place: Rigid<Ct, Tool>,
        number: u64,
        (pictures, seconds): (Option<&str>, &mut [f64; 2]),
    ) -> BoneLine {
        let (shape, patient) = (*self.probe.shape(), self.patient);
        let tissue = |[x, y, z]: [f64; 3]| patient.hu(Point::new(x, y, z));
        let began = monotonic_ns();
        let grey = self.probe.image(&tissue, place, number).unwrap();
        seconds[0] += crate::seconds_since(began);
        let began = monotonic_ns();
        let line = find(&UsImage::new(&shape, &grey).unwrap(), &Options::default()).unwrap();
        seconds[1] += crate::seconds_since(began);
        if let Some(folder) = pictures {
            picture(folder, &format!("{:03}-{number:03}", self.seed), &shape, &grey, &line);
        }
        line
    }

    /// How much further than the true bone a point lies along its beam, at the true speed of sound, mm; infinite where there is no bone.
    fn off_mm(&self, point: &BonePoint, place: Rigid<Ct, Tool>) -> f64 {
        let ([x, y], [along_x, along_y]) = self.probe.shape().along(point.beam.share, 0.0);
        let at = |mm: f64| place * self.probe.tool_from_image([x + mm * along_x, y + mm * along_y]);
        let bone = (0..4000)
            .map(|i| 0.02 * f64::from(i))
            .find(|mm| self.patient.hu(at(*mm)) > BONE_HU);
        bone.map_or(f64::INFINITY, |mm| point.beam.depth_mm * self.speed - mm)
    }
}

/// The points of a line, [`STEP_MM`] from one another.
fn apart(line: &BoneLine) -> Vec<&BonePoint> {
    let mut kept: Vec<&BonePoint> = Vec::new();
    for point in &line.points {
        let [x, y] = point.place_mm;
        let is_far = |last: &&BonePoint| (last.place_mm[0] - x).hypot(last.place_mm[1] - y) >= STEP_MM;
        if kept.last().is_none_or(is_far) {
            kept.push(point);
        }
    }
    kept
}

/// A point where a scanner that mirrors its picture shows it.
fn mirrored(point: &BonePoint, shape: &ultrasound::Shape) -> BonePoint {
    let mut point = *point;
    let middle = match shape.beams() {
        ultrasound::Beams::Linear { from_mm, to_mm, .. } => 0.5 * (from_mm + to_mm),
        ultrasound::Beams::Convex { centre_mm, .. } => centre_mm[0],
    };
    point.place_mm[0] = 2.0 * middle - point.place_mm[0];
    point.beam.direction[0] *= -1.0;
    point
}

/// A point of the bone, with the pose of the probe and its place on it.
struct Taken {
    point: SurfacePoint<Tracker>,
    pose: Rigid<Tracker, Probe>,
    on_probe: Point<Probe>,
}

fn seen(point: &BonePoint, pose: Rigid<Tracker, Probe>, probe_from_image: Rigid<Probe, Image>) -> Taken {
    let [x, y] = point.place_mm;
    let on_probe = probe_from_image * Point::<Image>::new(x, y, 0.0);
    let [along_x, along_y] = point.beam.direction;
    let direct =
        |x, y| -> Direction<Tracker> { (pose * probe_from_image) * checked::direction::<Image>([x, y, 0.0]).unwrap() };
    let noise = BeamNoise {
        axial_mm: point.axial_mm.hypot(POSE[0]),
        lateral_mm: point.lateral_mm.hypot(POSE[0]),
        elevation_mm: ELEVATION_MM.hypot(POSE[0]),
    };
    let beam = Beam {
        direction: direct(along_x, along_y),
        depth_mm: Some(point.beam.depth_mm),
    };
    Taken {
        point: SurfacePoint::seen(pose * on_probe, beam, direct(-along_y, along_x), noise),
        pose,
        on_probe,
    }
}

/// The points, with the error of the calibration that all share.
fn points(taken: &[Taken]) -> Points<Tracker> {
    let points: Vec<_> = taken.iter().map(|taken| taken.point).collect();
    let poses: Vec<_> = taken.iter().map(|taken| taken.pose).collect();
    let places: Vec<_> = taken.iter().map(|taken| taken.on_probe).collect();
    // About the probe's origin, as it is drawn.
    let mut covariance = Matrix6::zeros();
    for i in 0..3 {
        covariance[(i, i)] = CALIBRATION[1].powi(2);
        covariance[(3 + i, 3 + i)] = CALIBRATION[0].powi(2);
    }
    let shared = SharedError::of_tool(covariance, &poses, &places);
    Points::new(&points, Some(shared), HELD_MM).unwrap()
}

/// Bias, scatter and what was told, of those that are not far.
fn near(offs: &[[f64; 2]]) -> [f64; 3] {
    let near: Vec<&[f64; 2]> = offs.iter().filter(|[off, _]| off.abs() < FAR_MM).collect();
    let count = near.len() as f64;
    let bias = near.iter().map(|[off, _]| off).sum::<f64>() / count;
    let scatter = near.iter().map(|[off, _]| (off - bias).powi(2)).sum::<f64>() / count;
    let told = near.iter().map(|[_, told]| told * told).sum::<f64>() / count;
    [bias, scatter.sqrt(), told.sqrt()]
}

/// The image with its line in green.
fn picture(folder: &str, name: &str, shape: &ultrasound::Shape, grey: &[u8], line: &BoneLine) {
    let (columns, rows) = (shape.columns() as u32, shape.rows() as u32);
    let mut image = image::RgbImage::new(2 * columns, rows);
    for (at, level) in grey.iter().enumerate() {
        let (u, v) = (at as u32 % columns, at as u32 / columns);
        image.put_pixel(u, v, image::Rgb([*level; 3]));
        image.put_pixel(columns + u, v, image::Rgb([*level; 3]));
    }
    for point in &line.points {
        let [u, v] = point.pixel.map(|part| part.round() as u32);
        image.put_pixel(columns + u.min(columns - 1), v.min(rows - 1), image::Rgb([0, 255, 0]));
    }
    std::fs::create_dir_all(folder).unwrap();
    image.save(format!("{folder}/{name}.png")).unwrap();
}
