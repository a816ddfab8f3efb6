use bus::message::{ReplayState, Timeline};
use egui::{Event, Modifiers, PointerButton, Pos2};
use proptest::prelude::*;

use super::*;
use crate::model::Model;
use crate::screen::tests::samples::replay;
use crate::screen::tests::{monitor, shown};
use crate::screen::{Look, Wish};

fn bar(model: &Model) -> (Rect, Sizes) {
    let sizes = Sizes::with_bar(monitor([1920, 1080]), model.cells.len(), true).unwrap();
    let bar = sizes.bar.unwrap();
    let (_, right) = bar.split_left_right_at_x(bar.left() + WORDS * bar.width());
    (right.shrink2(vec2(sizes.gap, 2.0)), sizes)
}

fn pressed_at(model: &Model, at: Pos2) -> Vec<Wish> {
    let button = |pressed| Event::PointerButton {
        pos: at,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::default(),
    };
    let events = vec![Event::PointerMoved(at), button(true), button(false)];
    shown(model, monitor([1920, 1080]), &Look::default(), events).wishes
}

#[test]
fn what_is_pointed_at_is_where_it_goes() {
    let model = replay().model();
    let (track, _) = bar(&model);
    for part in [0.001_f32, 0.25, 0.5, 0.999] {
        let wishes = pressed_at(&model, pos2(track.left() + part * track.width(), track.center().y));
        let [Wish::Seek(t_ns)] = wishes[..] else {
            panic!("{part}: {wishes:?}");
        };
        // Eight seconds from second 1 on; a column of pixels is some six thousandths of a second.
        let expected = 1e9 + f64::from(part) * 8e9;
        assert!((t_ns as f64 - expected).abs() < 8e6, "{part}: {t_ns}");
    }
}

#[test]
fn the_bar_says_where_the_replay_stands_and_what_it_does_not_show() {
    let mut sample = replay();
    let says = |sample: &crate::model::sample::Sample, text: &str| {
        let outcome = shown(&sample.model(), monitor([1920, 1080]), &Look::default(), Vec::new());
        assert!(outcome.words.say(text), "{text}: {:?}", outcome.words);
    };
    says(&sample, "0:04.02 of 0:08.00  PLAYING 1 x");
    says(&sample, "reading 75 %");
    says(&sample, "band: tip 95 %, 0 to 1 mm");
    says(&sample, "mark 1 of 2: at the entry");
    sample.law.as_mut().unwrap().state = ReplayState::Ended.code();
    sample.now_ns = 60_000_000_000;
    says(&sample, "0:08.00 of 0:08.00  ENDED");
    sample.timeline = Some(std::rc::Rc::new(
        Timeline::default().because("a later version wrote it"),
    ));
    says(&sample, "not read on: a later version wrote it");
    sample.timeline = None;
    says(&sample, "what it holds is not read");
    assert_eq!(
        [time(-0.5), time(61.004), time(3600.0)],
        ["-0:00.50", "1:01.00", "60:00.00"]
    );
}

proptest! {
    /// No moment without a pose and no large error is lost, however few pixels there are.
    #[test]
    fn each_column_of_pixels_has_all_that_falls_into_it(
        states in prop::collection::vec(0_u32..128, 1..1024), pixels in 1_usize..2000, first in 0_i64..900, length in 1_i64..2000
    ) {
        let mut timeline = Timeline { column_ns: 1000, columns_count: states.len() as u32, ..Timeline::default() };
        for (k, (column, bits)) in timeline.columns.iter_mut().zip(&states).enumerate() {
            column.states = *bits;
            if *bits > 0 {
                column.error(k as f64);
            }
        }
        let mut model = replay().model().replay.unwrap();
        model.span_ns = [first * 1000, (first + length) * 1000];
        model.timeline = Some(std::rc::Rc::new(timeline));
        let found = columns::of(&model, pixels);
        prop_assert_eq!(found.len(), pixels);
        for (k, bits) in states.iter().enumerate() {
            // Any moment of what is replayed, seen where the bar has it.
            let t_ns = (k as i64) * 1000 + 500;
            if *bits == 0 || !(model.span_ns[0]..=model.span_ns[1]).contains(&t_ns) {
                continue;
            }
            let place = ((model.part(t_ns) * pixels as f64) as usize).min(pixels - 1);
            let column = found[place].unwrap();
            prop_assert_eq!(column.states & bits, *bits);
            prop_assert!(column.least_mm <= k as f32 && column.most_mm >= k as f32);
        }
        // And nothing that the recording does not have.
        let all = states.iter().fold(0, |all, bits| all | bits);
        prop_assert!(found.iter().flatten().all(|column| column.states & !all == 0));
    }
}

#[test]
fn one_large_error_does_not_flatten_the_others() {
    let top = |sample: crate::model::sample::Sample| {
        let model = sample.model().replay.unwrap();
        columns::top_mm(&columns::of(&model, 1400))
    };
    assert_eq!(top(replay()), Some(1.0));
    assert_eq!(columns::top_mm(&[None, None]), None);
}
