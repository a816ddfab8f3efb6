//! Which planes are looked at, and in which window. Pure.

use geometry::{Ct, Direction, PlaneError, Point, SlicePlane, Vector, VolumeGrid};
use guidance::plan::{Target, Trajectory};
use scene::WindowLevel;
use serde::{Deserialize, Serialize};

/// The images, in the order of the screen.
pub(crate) const CUTS: [Cut; 4] = [Cut::Axial, Cut::Frontal, Cut::Sagittal, Cut::Along];
/// What an image's side may show, mm.
const FIELD_MM: std::ops::RangeInclusive<f64> = 5.0..=1500.0;
/// What is seen beside the whole, parts of it.
const MARGIN: f64 = 1.05;
/// One step of the wheel turns the slice along the way by so much, rad: 5 degrees.
const TURN_RAD: f64 = 0.087_266_462_599_716_48;
/// The windows of the number keys: abdomen, soft tissue, bone, lung, vessels.
pub(crate) const PRESETS: [(&str, WindowLevel); 5] = [
    ("abdomen", window(40.0, 400.0)),
    ("soft tissue", window(50.0, 350.0)),
    ("bone", window(400.0, 1800.0)),
    ("lung", window(-600.0, 1500.0)),
    ("vessels", window(200.0, 700.0)),
];

const fn window(centre_hu: f64, width_hu: f64) -> WindowLevel {
    WindowLevel { centre_hu, width_hu }
}

/// A direction in which the examination is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Cut {
    /// Across the body, seen from the feet.
    Axial,
    /// Seen from the front.
    Frontal,
    /// Seen from the patient's left.
    Sagittal,
    /// Along the planned way, from the entry at the left to the target at the right.
    Along,
}

impl Cut {
    pub(crate) const fn place(self) -> usize {
        match self {
            Self::Axial => 0,
            Self::Frontal => 1,
            Self::Sagittal => 2,
            Self::Along => 3,
        }
    }

    /// For people.
    pub(crate) const fn title(self) -> &'static str {
        match self {
            Self::Axial => "AXIAL",
            Self::Frontal => "FRONTAL",
            Self::Sagittal => "SAGITTAL",
            Self::Along => "ALONG THE WAY",
        }
    }
}

/// Where somebody looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Camera {
    /// The point that the three slices go through.
    pub(crate) cursor: Point<Ct>,
    /// What is in the middle of each image, taken onto its plane; of the one along the way how far from its middle that is.
    focus: [Point<Ct>; 4],
    /// What the side of each image shows, mm.
    field_mm: [f64; 4],
    /// How far the slice along the way is turned about it.
    around_rad: f64,
    /// How HU become grey.
    pub(crate) window: WindowLevel,
}

impl Camera {
    /// The whole examination, from its middle.
    pub(crate) fn home(grid: &VolumeGrid) -> Self {
        let (low, high) = grid.bounds();
        let [x, y, z] = (high - low).mm();
        let field = |across: f64, down: f64| (across.max(down) * MARGIN).clamp(*FIELD_MM.start(), *FIELD_MM.end());
        Self {
            cursor: grid.centre(),
            focus: [grid.centre(); 4],
            field_mm: [field(x, y), field(x, z), field(y, z), field(x, y)],
            around_rad: 0.0,
            window: PRESETS[0].1,
        }
    }

    /// The same in the window that there is.
    pub(crate) fn reset(&mut self, grid: &VolumeGrid) {
        *self = Self {
            window: self.window,
            ..Self::home(grid)
        };
    }

    /// Looks at `p` in all three slices.
    pub(crate) fn look_at(&mut self, p: Point<Ct>) {
        self.cursor = p;
        self.focus[..3].fill(p);
    }

    /// The slice along the way to `target` shows all of it.
    pub(crate) fn fit(&mut self, target: &Target) {
        if let Some(way) = Trajectory::of(target) {
            self.fit_way(&way);
        }
    }

    fn fit_way(&mut self, way: &Trajectory) {
        self.focus[3] = way.at(way.depth_mm / 2.0);
        self.field_mm[3] = (way.depth_mm * 1.5).clamp(40.0, *FIELD_MM.end());
        self.around_rad = 0.0;
    }

    /// The plane of an image of `size` pixels; `None` along a way that there is not.
    pub(crate) fn plane(&self, cut: Cut, way: Option<&Trajectory>, size: [u32; 2]) -> Option<SlicePlane> {
        let (axes, on) = match cut {
            Cut::Axial => ([Direction::X, Direction::Y], self.cursor),
            Cut::Frontal => ([Direction::X, -Direction::Z], self.cursor),
            Cut::Sagittal => ([Direction::Y, -Direction::Z], self.cursor),
            Cut::Along => {
                let way = way?;
                ([way.axis, around(way.axis, self.around_rad)?], way.entry)
            }
        };
        self.through(cut, axes, on, size).ok()
    }

    fn through(
        &self,
        cut: Cut,
        axes: [Direction<Ct>; 2],
        on: Point<Ct>,
        size: [u32; 2],
    ) -> Result<SlicePlane, PlaneError> {
        let (focus, field_mm) = (self.focus[cut.place()], self.field_mm[cut.place()]);
        let normal = axes[0].cross(axes[1]);
        let centre = focus + normal * (on - focus).dot(normal);
        SlicePlane::centred(centre, axes, field_mm / f64::from(size[0].min(size[1])), size)
    }

    /// So many steps of the wheel over an image: to the next slices away from who looks, or around the way.
    pub(crate) fn turn_wheel(&mut self, cut: Cut, steps: f64, grid: &VolumeGrid) {
        let normal = match cut {
            Cut::Axial => Direction::Z,
            Cut::Frontal => Direction::Y,
            Cut::Sagittal => -Direction::X,
            Cut::Along => {
                let turned = self.around_rad + steps * TURN_RAD;
                self.around_rad = turned.rem_euclid(std::f64::consts::TAU);
                return;
            }
        };
        // From one slice of the examination to the next: its largest step along the normal of the image.
        let along = |axis| grid.ct_from_voxel().step(axis).dot(normal.vector()).abs();
        let step_mm = (0..3).map(along).fold(0.0, f64::max);
        self.cursor = within(self.cursor + normal * (steps * step_mm), grid);
    }

    /// Shows more or less of the examination: a factor below 1 enlarges.
    pub(crate) fn zoom(&mut self, cut: Cut, factor: f64) {
        let field = &mut self.field_mm[cut.place()];
        *field = (*field * factor).clamp(*FIELD_MM.start(), *FIELD_MM.end());
    }

    /// Moves what is in the middle of an image.
    pub(crate) fn pan(&mut self, cut: Cut, by: Vector<Ct>) {
        let focus = &mut self.focus[cut.place()];
        *focus = *focus + by;
    }

    /// Another window: so many HU wider, and so many up.
    pub(crate) fn level(&mut self, wider_hu: f64, up_hu: f64) {
        let WindowLevel { centre_hu, width_hu } = self.window;
        self.window = window(
            (centre_hu + up_hu).clamp(-2000.0, 4000.0),
            (width_hu + wider_hu).clamp(1.0, 8000.0),
        );
    }
}

/// The point of the examination's box that is nearest to `p`.
fn within(p: Point<Ct>, grid: &VolumeGrid) -> Point<Ct> {
    let (low, high) = grid.bounds();
    let [low, high] = [low.mm(), high.mm()];
    let p = p.mm();
    let [x, y, z] = std::array::from_fn(|axis| p[axis].clamp(low[axis], high[axis]));
    Point::new(x, y, z)
}

/// The direction across `axis` that is nearest to the feet, or to the back where the way goes along the body; turned about it.
fn around(axis: Direction<Ct>, turned_rad: f64) -> Option<Direction<Ct>> {
    let across = |d: Direction<Ct>| {
        let part = d.vector() - axis * d.dot(axis);
        part.direction().filter(|_| part.norm() > 0.1)
    };
    let down = across(-Direction::Z).or_else(|| across(Direction::Y))?;
    let beside = axis.cross(down);
    (down * turned_rad.cos() + beside * turned_rad.sin()).direction()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Affine, letters};
    use proptest::prelude::*;

    fn grid() -> VolumeGrid {
        let rows = [[0.8, 0.0, 0.0, -100.0], [0.0, 0.8, 0.0, -100.0], [0.0, 0.0, 2.5, -50.0]];
        VolumeGrid::checked([250, 250, 80], Affine::from_rows(rows)).unwrap()
    }

    fn way(entry: [f64; 3]) -> Trajectory {
        let [x, y, z] = entry;
        Trajectory::of(&Target {
            name: "n".to_owned(),
            centre: Point::new(0.0, 0.0, 0.0),
            diameter_mm: 5.0,
            entry: Some(Point::new(x, y, z)),
            stop_mm: 0.0,
        })
        .unwrap()
    }

    #[test]
    fn slices_go_through_the_cursor_and_the_patients_sides_are_where_radiologists_look_for_them() {
        let mut camera = Camera::home(&grid());
        camera.look_at(Point::new(12.0, -7.0, 33.0));
        let expected = [
            (Cut::Axial, ["L", "P"]),
            (Cut::Frontal, ["L", "I"]),
            (Cut::Sagittal, ["P", "I"]),
        ];
        for (cut, [right, down]) in expected {
            let plane = camera.plane(cut, None, [512, 512]).unwrap();
            assert_eq!([letters(plane.right()), letters(plane.down())], [right, down]);
            let at = plane.project(camera.cursor);
            assert!(at.depth_mm.abs() < 1e-12 && (at.x - 255.5).abs() < 1e-9 && (at.y - 255.5).abs() < 1e-9);
        }
        assert_eq!(camera.plane(Cut::Along, None, [512, 512]), None);
    }

    #[test]
    fn a_step_of_the_wheel_is_the_next_slice_of_the_examination_and_stays_in_it() {
        let grid = grid();
        let mut camera = Camera::home(&grid);
        let before = camera.cursor;
        for (cut, moved) in [
            (Cut::Axial, [0.0, 0.0, 2.5]),
            (Cut::Frontal, [0.0, 0.8, 0.0]),
            (Cut::Sagittal, [-0.8, 0.0, 0.0]),
        ] {
            let mut camera = camera;
            camera.turn_wheel(cut, 1.0, &grid);
            let by = (camera.cursor - before).mm();
            assert!((0..3).all(|i| (by[i] - moved[i]).abs() < 1e-12), "{cut:?} {by:?}");
            // Away from who looks.
            let plane = camera.plane(cut, None, [64, 64]).unwrap();
            assert!((camera.cursor - before).dot(plane.into_screen().vector()) > 0.0);
        }
        camera.turn_wheel(Cut::Axial, 1e9, &grid);
        assert_eq!(camera.cursor.mm()[2], grid.bounds().1.mm()[2]);
    }

    proptest! {
        /// Whatever its direction, the slice along a way holds all of it, from the left to the right, however it is turned.
        #[test]
        fn a_way_lies_in_its_slice(entry in prop::array::uniform3(-150.0..150.0_f64), turns in 0_i32..100) {
            prop_assume!(entry.iter().map(|x| x * x).sum::<f64>() > 4.0);
            let way = way(entry);
            let mut camera = Camera::home(&grid());
            camera.fit_way(&way);
            camera.turn_wheel(Cut::Along, f64::from(turns), &grid());
            let plane = camera.plane(Cut::Along, Some(&way), [512, 512]).unwrap();
            let (from, to) = (plane.project(way.entry), plane.project(way.stop));
            // Roundings of lengths of up to 260 mm.
            prop_assert!(from.depth_mm.abs() < 1e-11 && to.depth_mm.abs() < 1e-11);
            prop_assert!((from.y - to.y).abs() < 1e-9 && from.x < to.x);
            for p in [from, to] {
                prop_assert!((0.0..512.0).contains(&p.x) && (0.0..512.0).contains(&p.y));
            }
        }

        #[test]
        fn what_is_asked_for_is_what_a_renderer_draws(zoom in -20.0..20.0_f64, level in prop::array::uniform2(-1e6..1e6_f64)) {
            let mut camera = Camera::home(&grid());
            camera.zoom(Cut::Axial, zoom.exp());
            camera.level(level[0], level[1]);
            let plane = camera.plane(Cut::Axial, None, [512, 512]).unwrap();
            let asked = bus::message::ImagePlane::of(Some(&plane), camera.window);
            prop_assert!(asked.asked([512, 512]).is_ok());
        }
    }
}
