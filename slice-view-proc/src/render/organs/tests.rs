//! Images of organs that were moved: what is drawn where they were, where two are, and around it all.

use picture::{Rgb, palette};

use super::{GROUND, STRIPE};
use crate::overlay::Notice;
use crate::render::Renderer;
use crate::reslice::{Cpu, Resampler};
use crate::tissue::stage::{Block, HU_PER_MM, PIXEL_MM, SIDE, hu_at, rendered, scene, shapes, volume};
use crate::tissue::{Moved, Tissues};
use bus::message::TissueShown;

/// A cube beside the tube, and how far it is moved along x.
const MOVED: Block = Block([68.0, 50.0, 50.0], 16.0);
const BY: f64 = 6.0;
/// One that stays, into which the other comes: from 76 to 82 mm.
const STAYS: Block = Block([82.0, 50.0, 50.0], 12.0);

/// The image of organs whose nodes lie there: a moved one has its own nodes moved.
fn image(blocks: &[Block], nodes: &[Vec<[f32; 3]>]) -> Renderer {
    let (scene, volume) = (scene(), volume());
    let (shapes, places) = (shapes(blocks), nodes.concat());
    let mut what = rendered(&volume, Notice::Live);
    what.tissue = Tissues {
        shown: TissueShown::Settled,
        moved: Some(Moved {
            shapes: &shapes,
            places: &places,
        }),
        seq: 3,
        ..Tissues::default()
    };
    let mut renderer = Renderer::new(scene.views[0].clone());
    let mut cpu = Cpu::default();
    cpu.prepare(&what.volume, &[renderer.view().sampling], &mut || {})
        .unwrap();
    renderer.render(&what, &scene, &mut cpu).unwrap();
    renderer
}

/// The examination as it was taken, in a scene that moves organs, with this said of them.
fn without(tissue: Tissues<'_>) -> Renderer {
    let (scene, volume) = (scene(), volume());
    let mut what = rendered(&volume, Notice::Live);
    what.tissue = tissue;
    let mut renderer = Renderer::new(scene.views[0].clone());
    let mut cpu = Cpu::default();
    cpu.prepare(&what.volume, &[renderer.view().sampling], &mut || {})
        .unwrap();
    renderer.render(&what, &scene, &mut cpu).unwrap();
    renderer
}

fn at_rest() -> Renderer {
    without(Tissues::rigid())
}

fn pixel(renderer: &Renderer, [column, row]: [usize; 2]) -> Rgb {
    let at = 4 * (row * SIDE + column);
    let rgba = &renderer.canvas().rgba()[at..at + 4];
    Rgb(rgba[0], rgba[1], rgba[2])
}

/// The pixels whose middles lie in a part of the patient by more than half a pixel: columns along x, rows along y.
fn pixels([from, to]: [f64; 2], [above, below]: [f64; 2], renderer: &Renderer) -> Vec<[usize; 2]> {
    let plane = renderer.plane().unwrap();
    let half = 0.5 * PIXEL_MM;
    let all = (0..SIDE * SIDE).map(|at| [at % SIDE, at / SIDE]);
    let inside = |at: &[usize; 2]| {
        let [x, y, _] = plane.point(at[0] as f64, at[1] as f64).mm();
        x > from + half && x < to - half && y > above + half && y < below - half
    };
    all.filter(inside).collect()
}

fn moved() -> Vec<[f32; 3]> {
    MOVED.nodes(|_| [BY, 0.0, 0.0])
}

#[test]
fn where_tissue_was_is_hatched_and_where_it_is_now_has_the_hu_of_where_it_was() {
    let renderer = image(&[MOVED], &[moved()]);
    // From its old face to its new one.
    let vacated = pixels([60.0, 66.0], [42.0, 58.0], &renderer);
    assert!(vacated.len() > 500, "{}", vacated.len());
    let is_stripe = |at: [usize; 2]| pixel(&renderer, at) == STRIPE;
    for at in &vacated {
        let found = pixel(&renderer, *at);
        assert!(found == STRIPE || found == GROUND, "{at:?}: {found:?}");
        // Stripes from the upper left to the lower right: outside the examination they go the other way.
        let next = [at[0] + 1, at[1] + 1];
        assert!(!vacated.contains(&next) || is_stripe(*at) == is_stripe(next), "{at:?}");
    }
    let striped = vacated.iter().filter(|at| is_stripe(**at)).count();
    let share = striped as f64 / vacated.len() as f64;
    // Two of eight along each row; rows are 14 to 15 pixels here.
    assert!((0.15..0.35).contains(&share), "{share}");

    let tissue = pixels([66.0, 82.0], [42.0, 58.0], &renderer);
    for at in tissue {
        let x = renderer.plane().unwrap().point(at[0] as f64, at[1] as f64).mm()[0];
        let (found, wanted) = (f64::from(renderer.hu()[at[1] * SIDE + at[0]]), hu_at(x - BY));
        // 0.05 mm is the most that the raster is off.
        assert!((found - wanted).abs() < 0.05 * HU_PER_MM, "{at:?}: {found} {wanted}");
    }
    assert_eq!(renderer.covered_twice(), 0);

    // Of the same examination at rest nothing is hatched.
    let rest = at_rest();
    assert!(vacated.iter().all(|at| ![STRIPE, GROUND].contains(&pixel(&rest, *at))));
}

#[test]
fn what_two_places_claim_has_the_alarm_colour_and_is_counted_to_the_pixel() {
    let renderer = image(&[MOVED, STAYS], &[moved(), STAYS.nodes(|_| [0.0; 3])]);
    let both = pixels([76.0, 82.0], [44.0, 56.0], &renderer);
    assert!(both.len() > 300, "{}", both.len());
    for at in &both {
        assert_eq!(pixel(&renderer, *at), palette::ALARM, "{at:?}");
    }
    let all = (0..SIDE * SIDE).filter(|at| pixel(&renderer, [at % SIDE, at / SIDE]) == palette::ALARM);
    let all: Vec<usize> = all.collect();
    assert_eq!(renderer.covered_twice(), all.len());
    // No more than the pixels on its border besides.
    let border = (2.0 * (6.0 + 12.0) / PIXEL_MM).ceil() as usize + 4;
    assert!(all.len() <= both.len() + border, "{} {}", all.len(), both.len());
    // An image that shows no organs moved says nothing of the one before.
    let (scene, volume) = (scene(), volume());
    let mut what = rendered(&volume, Notice::Live);
    what.tissue = Tissues::rigid();
    let mut renderer = renderer;
    let mut cpu = Cpu::default();
    cpu.prepare(&what.volume, &[renderer.view().sampling], &mut || {})
        .unwrap();
    renderer.render(&what, &scene, &mut cpu).unwrap();
    assert_eq!(renderer.covered_twice(), 0);
}

/// One node pulled far through the others: a state may be called settled, and its image has tissue inside out.
#[test]
fn tissue_that_is_folded_has_the_alarm_colour_too() {
    let middle = MOVED.0;
    let renderer = image(
        &[MOVED],
        &[MOVED.nodes(|at| [if at == middle { 14.0 } else { 0.0 }, 0.0, 0.0])],
    );
    let all = (0..SIDE * SIDE).filter(|at| pixel(&renderer, [at % SIDE, at / SIDE]) == palette::ALARM);
    let all = all.count();
    assert!(all > 20, "{all}");
    assert_eq!(renderer.covered_twice(), all);
    // The frame, half of 5 pixels of 512 wide, says so too.
    assert_eq!(pixel(&renderer, [1, SIDE / 2 + 60]), palette::WARN);
}

#[test]
fn a_model_has_a_double_frame_and_the_examination_none() {
    // Along the upper rim, beside its letter and the title; the ruler's ticks lie over the left one.
    let bright = |renderer: &Renderer, column: usize| {
        let ground = pixel(renderer, [column, 9]).0;
        let rows = (0..9).filter(|row| pixel(renderer, [column, *row]).0 > ground + 20);
        rows.collect::<Vec<_>>()
    };
    let (renderer, rest) = (image(&[MOVED], &[moved()]), at_rest());
    for column in [100, 155] {
        // Lines of a pixel, their middles half a pixel from the rim and at 5.5.
        assert_eq!(bright(&renderer, column), [0, 1, 5, 6]);
        // Not the white of a model, but the amber of a word that says that organs are at rest.
        assert_eq!(pixel(&rest, [column, 1]), palette::WARN);
        assert!(bright(&rest, column).iter().all(|row| *row < 3));
    }
}

/// Nobody is to take organs that are not where they are drawn for those that are: words alone may be overlooked.
#[test]
fn an_image_whose_state_is_late_is_dimmed_and_one_that_claims_nothing_of_the_present_is_not() {
    let late = |late_ns| {
        without(Tissues {
            shown: TissueShown::Late,
            late_ns,
            ..Tissues::default()
        })
    };
    let (rest, late, asked) = (at_rest(), late(Some(400_000_000)), late(None));
    // Below the words and beside the tube.
    for column in [90, 160, 200] {
        let [bright, dim, same] = [&rest, &late, &asked].map(|renderer| pixel(renderer, [column, 200]));
        let wanted = u16::from(bright.0) * 170 / 256;
        assert!(
            u16::from(dim.0).abs_diff(wanted) <= 1 && bright.0 > 60,
            "{bright:?} {dim:?}"
        );
        assert_eq!(same, bright);
    }
}
