//! What an operation aims at and what a registration touches: lymph nodes, skin beads, and one good way in.

use geometry::{Ct, Point};

use crate::anatomy::{aorta_at, cava_at, iliac_artery};
use crate::canvas::{Canvas, Solid};
use crate::plan::Plan;
use crate::surface::Surface;
use crate::vec3::{Vec3, add, lerp, mirror};

/// A small round thing whose place is known exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Landmark {
    /// Its name, for instance `para-aortic-left`.
    pub name: String,
    /// Its middle, mm, LPS.
    pub centre: Point<Ct>,
    /// Its diameter at half contrast, mm.
    pub diameter_mm: f64,
}

/// A straight way from the skin to a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// Name of the target it leads to.
    pub target: String,
    /// Where the tube goes through the skin, mm, LPS.
    pub entry: Point<Ct>,
}

/// HU of a lymph node.
pub(crate) const NODE_HU: f64 = 60.0;
/// HU of a bead: metal.
pub(crate) const BEAD_HU: f64 = 3000.0;
const NODE_MM: f64 = 5.0;
const BEAD_MM: f64 = 2.0;
/// Name of the node that [`approach`] leads to.
const APPROACHED: &str = "para-aortic-left";

fn landmark(name: &str, [x, y, z]: Vec3, diameter_mm: f64) -> Landmark {
    Landmark {
        name: name.to_owned(),
        centre: Point::new(x, y, z),
        diameter_mm,
    }
}

/// Five nodes in the fat beside the great vessels.
pub(crate) fn nodes(plan: &Plan) -> Vec<Landmark> {
    let node = |name, p| landmark(name, p, NODE_MM);
    let beside = |side, s, offset| {
        let [_, fork, brim, _] = iliac_artery(plan, side);
        add(lerp(fork, brim, s), mirror(offset, side))
    };
    let aorta = aorta_at(plan, 50.0);
    vec![
        node(APPROACHED, [aorta[0] + 16.5, aorta[1] - 1.0, 50.0]),
        node("pre-aortic", add(aorta_at(plan, 64.0), [3.0, -15.5, 0.0])),
        node("para-caval-right", add(cava_at(plan, 44.0), [-17.5, -3.0, 0.0])),
        node("iliac-left", beside(1.0, 0.15, [4.0, -10.0, 0.0])),
        node("iliac-right", beside(-1.0, 0.4, [2.0, -10.5, 0.0])),
    ]
}

/// Eight beads on the skin: two rings of four, no two opposite each other, so that no symmetry hides a mistaken order.
pub(crate) fn beads(plan: &Plan) -> Vec<Landmark> {
    // (name, z, angle in degrees from the left side, going to the front).
    let places = [
        ("front-left-high", 150.0, 52.0),
        ("front-right-high", 138.0, 124.0),
        ("flank-right-high", 120.0, 172.0),
        ("flank-left-high", 128.0, 10.0),
        ("front-left-low", -20.0, 60.0),
        ("front-right-low", -34.0, 112.0),
        ("flank-right-low", 4.0, 184.0),
        ("flank-left-low", -12.0, -6.0),
    ];
    let bead = |(name, z, degrees): (&str, f64, f64)| {
        let angle = degrees.to_radians();
        // Half a bead further out than the skin: it lies on it.
        let on_skin = plan
            .skin
            .deeper(-BEAD_MM / 2.0)
            .exit([0.0, 0.0, z], [angle.cos(), -angle.sin()]);
        landmark(name, on_skin, BEAD_MM)
    };
    places.map(bead).into()
}

/// The way through the left flank, behind the bowel and under the kidney: the lomboscopy's.
pub(crate) fn approach(plan: &Plan, nodes: &[Landmark]) -> Approach {
    let target = nodes.iter().find(|n| n.name == APPROACHED);
    let from = target.map_or([0.0; 3], |n| n.centre.mm());
    // 18 degrees to the back of the patient's left.
    let angle = 18.0_f64.to_radians();
    let [x, y, z] = plan.skin.exit(from, [angle.cos(), angle.sin()]);
    Approach {
        target: APPROACHED.to_owned(),
        entry: Point::new(x, y, z),
    }
}

/// Paints nodes or beads, with their sharper edge, each of the structure of its number, or of none.
pub(crate) fn paint(canvas: &mut Canvas, hu: f64, landmarks: &[Landmark], structures: &[u16]) {
    for (k, mark) in landmarks.iter().enumerate() {
        let ball = Surface::Ball {
            centre: mark.centre.mm(),
            radius: mark.diameter_mm / 2.0,
        };
        canvas.add(Solid::sharp(hu, ball).of(Some(structures.get(k).copied().unwrap_or(0))));
    }
}
