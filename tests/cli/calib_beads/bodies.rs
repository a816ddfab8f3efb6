//! Metal that is no bead, beside bone in real CTs: how much of it is taken for one.

use bead::{Bead, Dense, Ground, Search, find};

use super::sites::{Body, KINDS, distance, planted, sites};

const METAL_HU: f64 = 14_000.0;

/// Bodies that are no beads of a radius, by name.
fn bodies(radius: f64) -> Vec<(String, Body)> {
    let step = radius / 4.0;
    let rod = move |axis: usize, thick: f64, long: f64| {
        let mut half = [thick; 3];
        half[axis] = 0.5 * long;
        let around =
            move |c: &[f64; 3]| (0..3).filter(|a| *a != axis).map(|a| c[a] * c[a]).sum::<f64>() <= thick * thick;
        Body::cut(half, step, around)
    };
    let mut all = Vec::new();
    for (axis, name) in [(0, "x"), (2, "z")] {
        for (thick, long) in [(0.5, 4.0), (0.5, 6.0), (0.5, 10.0), (0.8, 6.0), (1.0, 5.0), (1.0, 10.0)] {
            let [thick, long] = [thick * radius, long * radius];
            all.push((
                format!("rod along {name}, radius {thick}, length {long}"),
                rod(axis, thick, long),
            ));
        }
    }
    for share in [0.4, 0.5, 1.8, 2.0, 2.5] {
        all.push((
            format!("ball of radius {:.2}", share * radius),
            Body::ball(share * radius),
        ));
    }
    let plate = [2.5 * radius, 2.5 * radius, 0.3 * radius];
    all.push(("plate in the slice".to_owned(), Body::cut(plate, step, |_| true)));
    let plate = [0.3 * radius, 2.5 * radius, 2.5 * radius];
    all.push(("plate across slices".to_owned(), Body::cut(plate, step, |_| true)));
    let pair = move |c: &[f64; 3]| {
        [-1.0, 1.0]
            .iter()
            .any(|s| (c[0] - s * radius).powi(2) + c[1] * c[1] + c[2] * c[2] <= radius * radius)
    };
    all.push((
        "two balls that touch".to_owned(),
        Body::cut([2.0 * radius, radius, radius], step, pair),
    ));
    all
}

/// Plants up to `count` of each body that is asked for at each kind of place, and counts what is taken for a bead.
pub(crate) fn taken(what: &str, volume: &Dense, radius: f64, count: usize, asked: impl Fn(&str) -> bool) -> usize {
    let all = sites(volume, count, 5.0 * radius + 12.0, 11);
    let mut total = 0;
    for (name, body) in bodies(radius).into_iter().filter(|(name, _)| asked(name)) {
        let specimen = planted(volume, &all, &body, METAL_HU);
        let search = Search {
            ground: Ground::Correlated,
            ..Search::of_radius(radius)
        };
        let found = find(&specimen, &search).unwrap();
        let mut kinds = [0; KINDS.len()];
        for bead in &found.beads {
            let near = |b: &Bead| all.iter().find(|s| distance(&b.centre.mm(), &s.centre) < 8.0 * radius);
            if let Some(site) = near(bead) {
                kinds[site.kind] += 1;
                println!(
                    "  {name}: {} r {:.2} blur {:?} metal {:.0} residual {:.0}",
                    KINDS[site.kind].name, bead.radius_mm[0], bead.blur_mm, bead.metal_hu, bead.residual_hu
                );
            }
        }
        total += found.beads.len();
        println!(
            "{what}, {name}: {} of {} taken for beads, by place {kinds:?}",
            found.beads.len(),
            all.len()
        );
    }
    total
}
