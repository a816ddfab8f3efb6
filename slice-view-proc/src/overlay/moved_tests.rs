//! Targets in an organ that a model has moved.

use bus::message::{Chosen, PlaceError, TargetShown, TissueHeader, TissueShown};
use geometry::{Affine, Point, Rigid, Vector, VolumeGrid};

use super::*;
use crate::tissue::{Moved, Shapes, Tissues};
use crate::view;
use crate::warp::{Cube, Region, Shape};

/// A cube of 10 mm about a place, as an organ; and its nodes where they are at rest, moved by `by` of each place.
fn organ(centre: [f64; 3], by: impl Fn([f64; 3]) -> [f64; 3]) -> (Shapes, Vec<[f32; 3]>) {
    let low = centre.map(|x| x - 5.0);
    let cube = Cube {
        low,
        side: 10.0,
        nodes: std::array::from_fn(|k| k as u32),
    };
    let region = Region::new(low, 10.0, [2; 3], vec![-1.0; 8]).unwrap();
    let node = |k: usize| {
        let at = [k % 3, k / 3 % 3, k / 9];
        let at = std::array::from_fn(|a| low[a] + 5.0 * at[a] as f64);
        let by = by(at);
        std::array::from_fn(|a| (at[a] + by[a]) as f32)
    };
    let shapes = Shapes {
        mesh_id: [0; 32],
        ct_from_model: Rigid::identity(),
        organs: vec![Shape::new(&[cube], 27, region, 5.0).unwrap()],
    };
    (shapes, (0..27).map(node).collect())
}

/// Looks at an image along the tube's axis with its tip at (50, 50, 50), and the target "far", chosen, 20 mm beside it.
fn of_far<T>(tissue: Tissues<'_>, look: impl FnOnce(&Overlay<'_>) -> T) -> T {
    let text = "[[targets]]\nname = \"far\"\nct_mm = [70, 50, 50]";
    let scene = scene::Scene::parse(text, std::path::Path::new("")).unwrap();
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let grid = VolumeGrid::checked([100; 3], affine).unwrap();
    let view = &scene.views[6];
    let pose = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), Vector::new(50.0, 50.0, 50.0)).unwrap();
    let chosen = Chosen {
        name: "far".to_owned(),
        centre: Point::new(70.0, 50.0, 50.0),
        radius_mm: scene.targets[0].diameter_mm / 2.0,
        entry: None,
        stop_mm: 0.0,
    };
    look(&Overlay {
        view,
        plane: &view::plane(view, &grid, &pose).unwrap(),
        is_placed: true,
        views: &scene.views,
        pose: Some(pose),
        tool: &scene.tool,
        targets: &scene.targets,
        chosen: Some(&chosen),
        accuracy: None,
        outside: false,
        remarks: &[],
        notice: Notice::Live,
        origin: Origin::Tracker,
        seq: 7,
        registration_id: 1,
        volume: "01234567",
        marks: Marks::default(),
        caution: "",
        tissue,
    })
}

fn settled<'a>(shapes: &'a Shapes, places: &'a [[f32; 3]]) -> Tissues<'a> {
    Tissues {
        shown: TissueShown::Settled,
        moved: Some(Moved { shapes, places }),
        late_ns: None,
        seq: 1,
        force_n: None,
        errors: None,
        covered_twice: 0,
    }
}

fn words(overlay: &Overlay<'_>) -> String {
    let placed = overlay.words().layout.placed;
    let all: Vec<String> = placed.into_iter().map(|word| word.text).collect();
    all.join("|")
}

#[test]
fn a_target_in_a_moved_organ_is_where_the_model_has_it_and_both_distances_stand_on_the_image() {
    let (shapes, places) = organ([70.0, 50.0, 50.0], |_| [-5.0, 0.0, 0.0]);
    of_far(settled(&shapes, &places), |overlay| {
        let [at_rest, now] = [70.0, 65.0].map(|x| {
            let at = overlay.plane.project(Point::new(x, 50.0, 50.0));
            [at.x, at.y]
        });
        let outlines: Vec<_> = overlay.outlines().map(|outline| outline.circle.at).collect();
        let off = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        assert!(outlines.len() == 1 && off(outlines[0], now) < 1e-4 && off(now, at_rest) > 5.0);
        assert!(
            words(overlay).contains("far 15.0 mm, AT REST 20.0 mm"),
            "{}",
            words(overlay)
        );
        // Both places are inked, and the way between them.
        let mut canvas = Canvas::new(overlay.view.size[0], overlay.view.size[1]);
        overlay.draw_places_at_rest(&mut canvas);
        let middle = [0.5 * (now[0] + at_rest[0]), 0.5 * (now[1] + at_rest[1])];
        for [x, y] in [at_rest, middle] {
            let at = 4 * (y.round() as usize * overlay.view.size[0] as usize + x.round() as usize);
            assert!(canvas.rgba()[at..at + 3].iter().any(|c| *c > 100), "{x} {y}");
        }
    });
}

/// The image looks along z: its columns and rows are x and y of the CT, up to signs.
#[test]
fn the_ellipse_of_a_model_is_that_of_its_covariance_about_the_moved_place_and_what_is_not_known_is_said() {
    let (shapes, places) = organ([70.0, 50.0, 50.0], |_| [-5.0, 0.0, 0.0]);
    let mut header = TissueHeader {
        t_capture_ns: 300_000_000,
        errors_t_capture_ns: 250_000_000,
        errors_known: 1,
        ..TissueHeader::default()
    };
    // Deviations 1.5 mm along x, 0.5 mm along y, 2 mm along z, which is not seen.
    header.errors[0] = PlaceError {
        at_rest_mm: [70.0, 50.0, 50.0],
        covariance: [2.25, 0.0, 0.0, 0.25, 0.0, 4.0],
    };
    let drawn = |tissue: Tissues<'_>| {
        of_far(tissue, |overlay| {
            let mut canvas = Canvas::new(overlay.view.size[0], overlay.view.size[1]);
            overlay.draw_model_errors(&mut canvas);
            let at = overlay.plane.project(Point::new(65.0, 50.0, 50.0));
            let half = [1.5, 0.5].map(|mm: f64| 2.447_746_830_680_816 * mm / overlay.plane.pixel_mm());
            let is_inked = |x: f64, y: f64| {
                let at = 4 * (y.round() as usize * overlay.view.size[0] as usize + x.round() as usize);
                canvas.rgba()[at..at + 3].iter().any(|c| *c > 100)
            };
            let along = (overlay.plane.right().components()[0].abs() > 0.5, at);
            let [x, y] = if along.0 { half } else { [half[1], half[0]] };
            let on_it = [
                is_inked(at.x + x, at.y),
                is_inked(at.x - x, at.y),
                is_inked(at.x, at.y + y),
                is_inked(at.x, at.y - y),
            ];
            // Beyond it, by two widths of a line, is nothing.
            let beyond = [is_inked(at.x + x + 4.0, at.y), is_inked(at.x, at.y + y + 4.0)];
            let any = canvas.rgba().chunks_exact(4).any(|pixel| pixel[..3] != [0; 3]);
            (on_it, beyond, any, words(overlay))
        })
    };
    let known = Tissues {
        errors: Some(&header),
        ..settled(&shapes, &places)
    };
    let (on_it, beyond, _, said) = drawn(known);
    assert_eq!((on_it, beyond), ([true; 4], [false; 2]), "{said}");
    // The longest half axis in space: 2 mm times the root of chi squared's 95 % with three degrees of freedom.
    assert!(said.contains("|MODEL \u{b1}5.6 mm (95 %), 50 ms AGO"), "{said}");
    assert!(said.contains("far, MOVED 5.0 mm \u{b1}5.6 mm"), "{said}");
    let other = TissueHeader {
        errors_known: 0,
        ..header
    };
    let unknown = Tissues {
        errors: Some(&other),
        ..settled(&shapes, &places)
    };
    let not_settled = Tissues {
        shown: TissueShown::Approximate,
        ..known
    };
    for tissue in [unknown, not_settled, settled(&shapes, &places)] {
        let (.., any, said) = drawn(tissue);
        assert!(!any && said.contains("MODEL ERROR UNKNOWN"), "{said}");
        assert!(said.contains("MOVED 5.0 mm \u{b1}UNKNOWN"), "{said}");
    }
}

#[test]
fn a_target_goes_as_the_quadratic_map_of_its_cube_does() {
    let bent = |[x, y, z]: [f64; 3]| [0.02 * (y - 50.0) * (z - 50.0), 0.01 * (x - 68.0).powi(2), -3.0];
    let (shapes, places) = organ([70.0, 50.0, 50.0], bent);
    let moved = Moved {
        shapes: &shapes,
        places: &places,
    };
    for at in [
        [70.0, 50.0, 50.0],
        [65.0, 45.0, 55.0],
        [74.9, 52.0, 46.5],
        [66.25, 54.0, 45.0],
    ] {
        let found = moved.place(Point::new(at[0], at[1], at[2])).unwrap().mm();
        let by = bent(at);
        for a in 0..3 {
            // Nodes travel in single precision: half a unit of 75 mm, and the weights of 27 of them sum to less than 2.
            assert!((found[a] - at[a] - by[a]).abs() < 1e-5, "{at:?}: {found:?}");
        }
    }
}

#[test]
fn a_place_beside_all_cubes_goes_with_the_nearest_one_up_to_half_its_side() {
    let cube = |low: [f64; 3], side: f64, first: u32| Cube {
        low,
        side,
        nodes: std::array::from_fn(|k| first + k as u32),
    };
    // A large cube and a small one beside it, moved apart from one another; a region that reaches beyond both.
    let cubes = [cube([0.0; 3], 20.0, 0), cube([20.0, 0.0, 0.0], 10.0, 27)];
    let region = Region::new([-40.0; 3], 80.0, [2; 3], vec![-1.0; 8]).unwrap();
    let shape = Shape::new(&cubes, 54, region, 5.0).unwrap();
    let places: Vec<[f32; 3]> = (0..54)
        .map(|n| {
            let (cube, k) = (&cubes[n / 27], n % 27);
            let at = [k % 3, k / 3 % 3, k / 9];
            let moved = if n < 27 { 1.0 } else { -2.0 };
            std::array::from_fn(|a| (cube.low[a] + 0.5 * cube.side * at[a] as f64 + moved) as f32)
        })
        .collect();
    let found = |at: [f64; 3]| shape.moved(&places, at).map(|[x, ..]| x - at[0]);
    for (at, by) in [
        ([3.0, 4.0, 5.0], Some(1.0)),
        ([27.0, 9.0, 1.0], Some(-2.0)),
        // 3 mm above the large cube, and 4 mm beyond the small one.
        ([10.0, 10.0, 23.0], Some(1.0)),
        ([34.0, 5.0, 5.0], Some(-2.0)),
        // Half a side is the most: 10 mm of the one, 5 mm of the other.
        ([10.0, 10.0, 30.5], None),
        ([35.5, 5.0, 5.0], None),
    ] {
        let off = found(at).map_or(0.0, |found| (found - by.unwrap_or(f64::NAN)).abs());
        assert!(
            found(at).is_some() == by.is_some() && off < 1e-4,
            "{at:?}: {:?}",
            found(at)
        );
    }
}

#[test]
fn what_no_moved_organ_holds_stays_where_it_is() {
    let (beside, places) = organ([50.0, 80.0, 50.0], |_| [9.0; 3]);
    let not_settled = Tissues {
        shown: TissueShown::Approximate,
        ..settled(&beside, &places)
    };
    let all = [
        (not_settled, TargetShown::NotSettled, "MODEL NOT SETTLED"),
        (
            settled(&beside, &places),
            TargetShown::Beside,
            "far 20.0 mm, NOT IN THE MODEL",
        ),
        (Tissues::rigid(), TargetShown::AtRest, "ORGANS AT REST"),
        (Tissues::default(), TargetShown::Planned, "far 20.0 mm"),
    ];
    for (tissue, shown, wanted) in all {
        assert_eq!(tissue.target(Point::new(70.0, 50.0, 50.0)).1, shown);
        of_far(tissue, |overlay| {
            let said = words(overlay);
            assert!(
                said.contains("far 20.0 mm") && said.contains(wanted) && !said.contains("AT REST 20"),
                "{said}"
            );
            let mut canvas = Canvas::new(overlay.view.size[0], overlay.view.size[1]);
            let before = canvas.rgba().to_vec();
            overlay.draw_places_at_rest(&mut canvas);
            assert_eq!(canvas.rgba(), before);
        });
    }
}

/// The pixels alone, without a word or a number anywhere, were all that told of a folded model.
#[test]
fn tissue_that_is_covered_twice_is_said_whatever_the_state_is_called() {
    let (shapes, places) = organ([70.0, 50.0, 50.0], |_| [-5.0, 0.0, 0.0]);
    for shown in [TissueShown::Settled, TissueShown::Approximate] {
        let once = Tissues {
            shown,
            ..settled(&shapes, &places)
        };
        let twice = Tissues {
            covered_twice: 31,
            ..once
        };
        of_far(once, |overlay| {
            assert!(!words(overlay).contains("COVERED"), "{}", words(overlay))
        });
        of_far(twice, |overlay| {
            let said = words(overlay);
            assert!(
                said.contains("TISSUE COVERED TWICE: 31 px") && said.contains("MODEL"),
                "{said}"
            );
            assert_eq!(overlay.frame().map(|(colour, _)| colour), Some(palette::WARN));
        });
    }
}
