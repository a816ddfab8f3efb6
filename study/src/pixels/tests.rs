//! What is read is what was painted, and what was not painted is no picture.

use hand::{Approach, Errors, Task};

use super::*;

fn shown() -> Shown {
    let task = Task::draw(5, 1, Approach::Oblique);
    let pose = task.way.pose(&task.start).unwrap();
    Shown {
        pose,
        covariance: Errors::noisy(0.3).stated(pose, task.aim.target),
        aim: task.aim,
        entry: task.way.entry(),
    }
}

/// Memory that does not hold the screen: the painter refuses it.
#[test]
fn a_frame_that_is_not_painted_is_told() {
    let mut reader = PixelReader::new().unwrap();
    assert!(reader.read(0, &shown()).is_some());
    assert!(reader.painted().is_ok());
    reader.memory.pop();
    assert_eq!(reader.read(0, &shown()), None);
    let why = reader.painted().unwrap_err().to_string();
    assert!(why.starts_with("a frame of the window was not painted: "), "{why}");
    // It stays so, also where the next one is painted.
    reader.memory.push(0);
    assert!(reader.read(0, &shown()).is_some() && reader.painted().is_err());
}

/// A pixel beside the screen has no colour: nothing is read of what is not there.
#[test]
fn there_are_no_pixels_beside_the_screen() {
    let reader = PixelReader::new().unwrap();
    for (x, y) in [(-1, 0), (0, -1), (1920, 0), (0, 1080)] {
        assert_eq!(reader.colour(x, y), None, "{x} {y}");
    }
    assert_eq!(reader.colour(1919, 1079), Some(Rgb(0, 0, 0)));
}
