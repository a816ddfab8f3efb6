//! What the tissue bears in a state: where it is deformed most, and how far it lies in the tube between the points that press.

use nalgebra::{Matrix3, Vector3};
use organs::body::displacement;
use organs::{Body, Labels, Model};
use simulation::space::cells::{Field, SurfacePoint};

/// Tissue may be as deep in the tube between its points as this part of the tube's radius, as of points inside (`NoEquilibrium::Through`), and no deeper
/// than this part of a cube's side: a wide tube has not come through a surface that its points do not follow, but has not pushed it either.
const MOST_BETWEEN: f64 = 0.2;
const MOST_OF_SIDE: f64 = 0.1;
/// Around a point places are looked at on so many rings, up to the length that its area has.
const RINGS: usize = 3;
/// Places on a ring.
const ON_RING: usize = 12;

/// A place of an organ's surface that lies in the tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Between {
    /// mm; 0 where none does.
    pub(super) depth: f64,
    /// In the label map's axes, at rest.
    pub(super) at: Vector3<f64>,
    /// Side of the organ's smallest cubes, mm.
    pub(super) side: f64,
}

/// Where an organ's tissue is deformed most.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Worst {
    body: usize,
    /// At rest, in the label map's axes.
    at: Vector3<f64>,
    determinant: f64,
    /// Principal stretches, the least first.
    stretches: [f64; 3],
}

/// The deepest place of surfaces in the tube, between their points too: rings of places on the surface around each that may meet it.
pub(super) fn between(model: &Model, a: &[f64]) -> Between {
    let mut deepest = Between {
        depth: 0.0,
        at: Vector3::zeros(),
        side: f64::INFINITY,
    };
    for (k, (body, contact)) in model.bodies.iter().zip(&model.system.tubes).enumerate() {
        let (tube, part) = (contact.tube(), model.system.bodies.part(k, a));
        let solid = model.system.bodies.solid(k);
        let grid = body.mesh.grid();
        let side = grid.cells().map(|c| grid.length(c.span)).fold(f64::INFINITY, f64::min);
        for (point, surface) in body.mesh.surface.iter().enumerate() {
            let reach = surface.area.sqrt();
            // No place of a ring comes nearer to the tube than by its way from the point, stretched.
            let away = tube.signed_distance(&solid.point(part, point)).value;
            if away > 2.0 * reach * solid.stretch(part, point).max(1.0) {
                continue;
            }
            if -away > deepest.depth {
                deepest = Between {
                    depth: -away,
                    at: surface.at,
                    side,
                };
            }
            for at in rings(body, surface, reach) {
                let Some(row) = body.mesh.row(&at) else { continue };
                let depth = -tube.signed_distance(&(at + displacement(&row, part))).value;
                if depth > deepest.depth {
                    deepest = Between { depth, at, side };
                }
            }
        }
    }
    deepest
}

/// Why a state is none for a tube of this radius: its surface lies in the tube between points.
pub(super) fn refused(found: &Between, radius: f64, labels: &Labels) -> Option<String> {
    let most = (MOST_BETWEEN * radius).min(MOST_OF_SIDE * found.side);
    (found.depth > most).then(|| {
        format!(
            "between the points that press the surface lies {:.2} mm deep in the tube, at {} mm at rest; more than {most:.2} mm says that it is not pushed as the tube is. \
             Use smaller cubes at the tube: organs.cubes, levels and within",
            found.depth,
            place(labels, &found.at)
        )
    })
}

/// Places on the surface around a point of it.
fn rings(body: &Body, point: &SurfacePoint, reach: f64) -> Vec<Vector3<f64>> {
    let across = point.normal.cross(&Vector3::ith(point.normal.iamin(), 1.0));
    let across = across / across.norm();
    let other = point.normal.cross(&across);
    let mut places = Vec::with_capacity(RINGS * ON_RING);
    for n in 0..RINGS * ON_RING {
        let angle = std::f64::consts::TAU * (n % ON_RING) as f64 / ON_RING as f64;
        let radius = reach * (n / ON_RING + 1) as f64 / RINGS as f64;
        let mut at = point.at + (across * angle.cos() + other * angle.sin()) * radius;
        // From the tangent plane back to the surface: one step of Newton's method, as the way is short beside the surface's radius.
        let slope = body.field.slope(&at);
        let steep = slope.norm_squared();
        if steep > 0.0 {
            at -= slope * (body.field.value(&at) / steep);
        }
        places.push(at);
    }
    places
}

/// What the last state of a search that failed looks like, in words.
pub(super) fn described(model: &Model, labels: &Labels, a: &[f64]) -> String {
    let mut words = String::new();
    if let Some(worst) = worst(model, a) {
        let [least, middle, most] = worst.stretches;
        words = format!(
            "The tissue of {:?} is deformed most at {} mm (at rest): det F {:.3}, stretches {least:.3}, {middle:.3}, {most:.3}. ",
            model.bodies[worst.body].name,
            place(labels, &worst.at),
            worst.determinant
        );
    }
    if let Some((stretch, at)) = surface_stretch(model, a) {
        words += &format!(
            "The surface is stretched {stretch:.2} times at {} mm. ",
            place(labels, &at)
        );
    }
    let found = between(model, a);
    if found.depth > 0.0 {
        words += &format!(
            "Its surface is up to {:.2} mm deep in the tube, at {} mm. ",
            found.depth,
            place(labels, &found.at)
        );
    }
    words
}

/// The point of all elements with the least determinant.
fn worst(model: &Model, a: &[f64]) -> Option<Worst> {
    let mut worst: Option<Worst> = None;
    for (k, body) in model.bodies.iter().enumerate() {
        let part = model.system.bodies.part(k, a);
        for point in body.mesh.points() {
            let gradient = deformation(&body.mesh.slopes(point), part);
            let determinant = gradient.determinant();
            if worst.is_none_or(|w| determinant < w.determinant) {
                let mut stretches: [f64; 3] = gradient.singular_values().into();
                stretches.sort_by(f64::total_cmp);
                worst = Some(Worst {
                    body: k,
                    at: point.at,
                    determinant,
                    stretches,
                });
            }
        }
    }
    worst
}

fn deformation(slopes: &[(u32, Vector3<f64>)], part: &[f64]) -> Matrix3<f64> {
    let by = |node: u32| Vector3::from_fn(|k, _| part[3 * node as usize + k]);
    let gradient: Matrix3<f64> = slopes.iter().map(|(node, slope)| by(*node) * slope.transpose()).sum();
    Matrix3::identity() + gradient
}

/// The largest stretch along a surface, and where.
fn surface_stretch(model: &Model, a: &[f64]) -> Option<(f64, Vector3<f64>)> {
    let bodies = &model.system.bodies;
    let each = (0..bodies.len()).flat_map(|k| {
        let (solid, part) = (bodies.solid(k), bodies.part(k, a));
        (0..solid.points()).map(move |point| (solid.stretch(part, point), solid.reference(point).0))
    });
    each.max_by(|one, other| one.0.total_cmp(&other.0))
}

fn place(labels: &Labels, at: &Vector3<f64>) -> String {
    let at = labels.patient(at);
    format!("({:.1}, {:.1}, {:.1})", at.x, at.y, at.z)
}

#[cfg(test)]
mod tests {
    use super::super::Space;
    use super::super::tests::READ;
    use super::super::tests::maps::{SCENE, folder};
    use super::*;

    fn ball() -> Space {
        let (_folder, path) = folder(&Matrix3::identity(), 0.0);
        Space::new(SCENE.to_owned(), &path, None, READ).unwrap()
    }

    /// A ball at rest and a tube put into it: the deepest place is where it first touched, as deep as the tube has gone since.
    #[test]
    fn a_tube_in_tissue_at_rest_is_as_deep_as_it_has_gone() {
        let mut space = ball();
        let a = space.model.system.initial();
        for gone in [0.0, 0.1, 1.5] {
            let tube = space.model.way.tube(space.model.free + gone).unwrap();
            space.model.system.tubes[0].move_to(tube);
            let found = between(&space.model, &a).depth;
            let points = space.model.system.tubes[0].depth(&space.model.system.bodies, &a);
            // Points are 0.75 mm apart: the first one to be touched is at most 0.55 mm aside of the place that is touched first, so at most
            // 0.55^2 / 2 (1/6 + 1/20) = 0.033 mm deeper than it; places on rings are at most 0.2 mm aside, 0.005 mm.
            assert!((gone - 0.006..gone + 0.034).contains(&found), "{found} after {gone}");
            assert!(points <= found + 1e-9, "{points} {found}");
        }
        // A fifth of the radius, and a tenth of the side of cubes of 6 mm.
        let found = between(&space.model, &a);
        for (radius, most) in [(2.0, "0.40 mm"), (6.0, "0.60 mm")] {
            let words = refused(&found, radius, &space.labels).unwrap();
            assert!(words.contains("between the points") && words.contains(most), "{words}");
        }
        let shallow = Between { depth: 0.5, ..found };
        assert!(refused(&shallow, 6.0, &space.labels).is_none() && refused(&shallow, 2.0, &space.labels).is_some());
    }

    /// A ball squeezed evenly: its least determinant and its stretches are those of the map.
    #[test]
    fn what_is_deformed_most_is_told_with_its_stretches() {
        let space = ball();
        let places = space.model.system.places();
        let a: Vec<f64> = (0..places.len())
            .map(|k| places[k][k % 3] * [0.25, -0.5, 0.0][k % 3])
            .collect();
        let worst = worst(&space.model, &a).unwrap();
        let far = (worst.determinant - 0.625).abs();
        assert!(far < 1e-9, "{}", worst.determinant);
        for (found, exact) in worst.stretches.iter().zip([0.5, 1.0, 1.25]) {
            assert!((found - exact).abs() < 1e-9, "{:?}", worst.stretches);
        }
        let words = described(&space.model, &space.labels, &a);
        assert!(
            words.contains("det F 0.625, stretches 0.500, 1.000, 1.250") && words.contains("1.25 times"),
            "{words}"
        );
    }
}
