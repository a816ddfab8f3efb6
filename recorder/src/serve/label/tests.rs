use super::*;
use bus::message::{FrameStamp, Lost};
use picture::Rgb;

const PLAIN: Label = Label {
    origin: "",
    is_withheld: false,
};

fn header(width: u32, height: u32, state: FrameState) -> FrameHeader {
    FrameHeader {
        stamp: FrameStamp {
            state: state.code(),
            ..FrameStamp::default()
        },
        width,
        height,
        ..FrameHeader::default()
    }
}

/// An image all in white whose own words say `drawn`, as it is given out when it may claim `state`.
fn white([width, height]: [u32; 2], was: FrameState, state: FrameState, label: Label) -> Canvas {
    let rgba = vec![255; 4 * width as usize * height as usize];
    let shown = Shown {
        state: Some(state),
        rgba: &rgba,
    };
    drawn(&header(width, height, was), shown, label).unwrap()
}

/// The brightest level in the image above its lines.
fn brightest(canvas: &Canvas) -> u8 {
    let pixels = canvas.rgba().chunks_exact(4);
    let above = pixels.take((canvas.width() * (canvas.height() - 2 * LINE)) as usize);
    above.flat_map(|pixel| &pixel[..3]).copied().max().unwrap()
}

/// The window covers images while the examination is not the patient's or the marker on the patient was pushed; these were shown as ever.
#[test]
fn an_image_is_covered_as_long_as_the_workflow_withholds_it() {
    let withheld = Label {
        is_withheld: true,
        ..PLAIN
    };
    let live = FrameState::Live;
    assert_eq!(brightest(&white([256, 256], live, live, PLAIN)), 255);
    assert_eq!(brightest(&white([256, 256], live, live, withheld)), 0);
    assert_eq!(claim(Some(live), false, withheld, 0).0, "WITHHELD");
}

#[test]
fn an_image_that_grew_old_is_dimmed_and_called_so() {
    let lost = FrameState::Lost(Lost::Silent);
    let old = white([256, 256], FrameState::Live, lost, PLAIN);
    assert!(brightest(&old) < 128, "{}", brightest(&old));
    assert_eq!(claim(Some(lost), true, PLAIN, 0).0, "OLD, NO POSE");
}

/// The renderer's words are shrunk with the image, and none can be read: the lines under it say the same.
#[test]
fn every_state_and_every_origin_stands_under_the_image() {
    let says = |state, label, replay| claim(state, false, label, replay).0;
    let replay = Label {
        origin: "REPLAY, NOT LIVE",
        ..PLAIN
    };
    assert_eq!(says(Some(FrameState::Live), PLAIN, 0), "");
    assert_eq!(says(Some(FrameState::Stale), PLAIN, 0), "POSE OLD");
    assert_eq!(says(Some(FrameState::Requested), PLAIN, 0), "A POSE ASKED FOR");
    assert_eq!(says(Some(FrameState::Look), PLAIN, 0), "A PLANE ASKED FOR");
    assert_eq!(says(None, PLAIN, 0), "UNKNOWN STATE");
    for reason in Lost::ALL {
        let lost = Some(FrameState::Lost(reason));
        assert_eq!(says(lost, PLAIN, 0), "NO POSE");
        assert_eq!(says(lost, replay, 1), "REPLAY, NOT LIVE, NO POSE");
    }
    // The stamp is believed where the run says nothing.
    assert_eq!(says(Some(FrameState::Live), PLAIN, 1), "REPLAY, NOT LIVE");
    assert_eq!(says(Some(FrameState::Live), PLAIN, 2), "SIMULATED TIME, NOT LIVE");
}

/// A view of few columns cut RESEARCH DISPLAY off at both ends.
#[test]
fn the_words_have_room_under_an_image_however_narrow() {
    let longest = Label {
        origin: "SIMULATED TIME, NOT LIVE",
        ..PLAIN
    };
    let lost = FrameState::Lost(Lost::Silent);
    let canvas = white([20, 200], FrameState::Live, lost, longest);
    let lines = canvas.rgba().chunks_exact(4 * canvas.width() as usize).skip(200);
    let Rgb(r, g, b) = RIM;
    let mut letters = 0;
    for row in lines {
        let [first, last] = [&row[..3], &row[row.len() - 4..row.len() - 1]];
        assert_eq!(
            (first, last),
            (&[r, g, b][..], &[r, g, b][..]),
            "a letter at the border"
        );
        letters += row.chunks_exact(4).filter(|pixel| pixel[..3] != [r, g, b]).count();
    }
    assert!(letters > 500, "{letters}");
}

#[test]
fn an_image_of_nothing_is_not_given_out() {
    let shown = Shown {
        state: Some(FrameState::Live),
        rgba: &[],
    };
    assert!(small_png(&header(0, 0, FrameState::Live), shown, PLAIN).is_none());
}
