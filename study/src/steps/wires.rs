//! The phantom of wires that the probe is calibrated by: its drawing, where it truly stands, and where its wires are seen.

use chance::Chance;
use geometry::{Ct, Image, Phantom, Point, Reference, Rigid, Tool, Vector};

use super::sequence::matrix;
use crate::plan::Surface;

/// Three N, 15 mm above one another: the name of each wire and its ends, mm.
const WIRES: [(&str, [f64; 3], [f64; 3]); 9] = [
    ("a", [0.0, 0.0, 0.0], [0.0, 40.0, 0.0]),
    ("b", [5.0, 0.0, 0.0], [35.0, 40.0, 0.0]),
    ("c", [40.0, 0.0, 0.0], [40.0, 40.0, 0.0]),
    ("d", [0.0, 0.0, 15.0], [0.0, 40.0, 15.0]),
    ("e", [35.0, 0.0, 15.0], [5.0, 40.0, 15.0]),
    ("f", [40.0, 0.0, 15.0], [40.0, 40.0, 15.0]),
    ("g", [0.0, 0.0, 30.0], [0.0, 40.0, 30.0]),
    ("h", [5.0, 0.0, 30.0], [35.0, 40.0, 30.0]),
    ("i", [40.0, 0.0, 30.0], [40.0, 40.0, 30.0]),
];
const MIDDLE_MM: [f64; 3] = [20.0, 20.0, 15.0];
/// From the probe's face to the middle of the wires, mm.
const DEPTH_MM: f64 = 38.0;
/// Where the phantom is told to stand, before the patient, with its wires across him and its top to the front.
const STANDS_MM: [f64; 3] = [0.0, -300.0, 0.0];
/// Deviations of where a wire is seen, along a row, along a column and across the image, mm: what `calib probe` takes them for where nothing else is said.
const SEEN_MM: [f64; 3] = [0.2, 0.15, 0.4];
/// The largest lean of the probe about each axis, rad.
const LEANS: [f64; 3] = [0.3, 0.25, 0.3];

/// The phantom in a room.
pub(super) struct Wires {
    told: Rigid<Reference, Phantom>,
    truly: Rigid<Ct, Phantom>,
    chance: Chance,
}

impl Wires {
    /// Off the place that is told of it by the deviations of the plan, turning about its middle.
    pub(super) fn new(surface: &Surface, ct_from_reference: Rigid<Ct, Reference>, chance: Chance) -> Self {
        let [x, y, z] = STANDS_MM;
        let upright = Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
        let stands = small::<Ct, Phantom>(upright, Vector::new(x, y, z));
        let drawn = |first: u64, size: f64| {
            let [a, b, c] = [0, 1, 2].map(|k| size * chance.normal(first + k));
            Vector::<Phantom>::new(a, b, c)
        };
        let [mm, deg] = surface.phantom;
        let [a, b, c] = MIDDLE_MM;
        let to_middle = small::<Phantom, Phantom>(Vector::new(0.0, 0.0, 0.0), Vector::new(a, b, c));
        let off = to_middle * small::<Phantom, Phantom>(drawn(0, deg.to_radians()), drawn(3, mm)) * to_middle.inverse();
        Self {
            told: ct_from_reference.inverse() * stands,
            truly: stands * off,
            chance,
        }
    }

    /// The probe in so many views, leaning to all sides; `tool_from_image` is where its image truly lies, `face_mm` the middle of its face there.
    pub(super) fn views(
        &self,
        count: u64,
        (tool_from_image, face_mm): (Rigid<Tool, Image>, [f64; 2]),
    ) -> Vec<Rigid<Ct, Tool>> {
        let [fx, fy] = face_mm;
        // Rows along the phantom's x, beams down; the place under the face goes to the middle of the wires.
        let quarter = Vector::new(-std::f64::consts::FRAC_PI_2, 0.0, 0.0);
        let upright = small::<Phantom, Image>(quarter, Vector::new(-fx, 0.0, fy + DEPTH_MM));
        let view = |k: u64| {
            let k = k as f64;
            let [a, b, c] = [
                LEANS[0] * k.sin(),
                LEANS[1] * (2.0 * k).cos(),
                LEANS[2] * (1.3 * k).sin(),
            ];
            let [x, y, z] = MIDDLE_MM;
            let lean = small::<Phantom, Phantom>(Vector::new(a, b, c), Vector::new(x, y + 8.0 * (0.7 * k).sin(), z));
            self.truly * lean * upright * tool_from_image.inverse()
        };
        (0..count).map(view).collect()
    }

    /// Where the wires are seen in these views, as `calib probe` reads it: pixels of this size.
    pub(super) fn points(
        &self,
        views: &[Rigid<Ct, Tool>],
        tool_from_image: Rigid<Tool, Image>,
        pixel_mm: f64,
    ) -> String {
        let mut text = "frame,wire,u,v\n".to_owned();
        for (number, view) in (0_u64..).zip(views) {
            let image_from_phantom = (*view * tool_from_image).inverse() * self.truly;
            for (place, (name, front, back)) in (0_u64..).zip(WIRES) {
                let [a, b] = [front, back].map(|[x, y, z]| (image_from_phantom * Point::new(x, y, z)).mm());
                let draw = 100 + 3 * (number * WIRES.len() as u64 + place);
                let [along, down, across] = [0, 1, 2].map(|k| SEEN_MM[k] * self.chance.normal(draw + k as u64));
                // Where the wire is as far across the image as this echo of it.
                let share = (across - a[2]) / (b[2] - a[2]);
                if (0.0..=1.0).contains(&share) {
                    let at = |k: usize, off: f64| (a[k] + share * (b[k] - a[k]) + off) / pixel_mm;
                    text += &format!("{number},{name},{:?},{:?}\n", at(0, along), at(1, down));
                }
            }
        }
        text
    }

    /// The drawing, and where it is told to stand: a device set of PLUS.
    pub(super) fn config(&self) -> String {
        let end = |[x, y, z]: [f64; 3]| format!("{x} {y} {z}");
        let wire = |(name, front, back): (&str, [f64; 3], [f64; 3])| {
            format!(
                "<Wire Name=\"{name}\" EndPointFront=\"{}\" EndPointBack=\"{}\"/>",
                end(front),
                end(back)
            )
        };
        format!(
            "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Phantom\" To=\"Reference\" Matrix=\"{}\"/></CoordinateDefinitions>\
             <PhantomDefinition><Geometry><Pattern>{}</Pattern></Geometry></PhantomDefinition></PlusConfiguration>\n",
            matrix(&self.told),
            WIRES.map(wire).concat()
        )
    }
}

/// A motion; any vectors of finite numbers are one.
fn small<A: geometry::Frame, B: geometry::Frame>(turn: Vector<A>, shift: Vector<A>) -> Rigid<A, B> {
    Rigid::from_rotation_vector(turn, shift).unwrap_or(Rigid::identity())
}
