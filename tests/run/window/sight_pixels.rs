//! What is read off the pixels of the window is what the sight says.

use chance::Chance;
use guidance::sight::Aim;
use hand::{Approach, Dial, Errors, Posture, Reader, Shown, SightReader, Task};

#[path = "../../../benches/hand/pixels.rs"]
mod pixels;

use pixels::{PixelReader, SCREEN, dial};

/// Up to here from the middle, pixels, the target's ring stays clear of the dot in its middle.
const APART_PX: f64 = 60.0;

/// A tube that is to go on for `ahead_mm` and points `beside_mm` beside the target.
fn shown(number: u64, beside_mm: f64, ahead_mm: f64) -> Shown {
    let chance = Chance::new(5, number);
    let mut task = Task::draw(5, number, Approach::Oblique);
    // So large that ON TARGET is said in every tenth case.
    task.aim = Aim {
        radius_mm: 2.0 + 4.0 * chance.uniform(2),
        ..task.aim
    };
    let (sin, cos) = (std::f64::consts::TAU * chance.uniform(0)).sin_cos();
    let tilt = beside_mm / 90.0;
    let posture = Posture {
        tilt: [tilt * cos, tilt * sin],
        depth_mm: 90.0 - ahead_mm,
    };
    let pose = task.way.pose(&posture).unwrap();
    Shown {
        pose,
        covariance: Errors::noisy(0.3).stated(pose, task.aim.target),
        aim: task.aim,
        entry: task.way.entry(),
    }
}

#[test]
fn pixels_say_what_the_sight_says() {
    let scale = dial(SCREEN);
    let of_crate = [Dial::FULL_HD.rim_px, Dial::FULL_HD.bar_px, Dial::FULL_HD.hidden_px];
    let of_screen = [scale.rim_px, scale.bar_px, scale.hidden_px];
    assert!(
        of_crate.iter().zip(of_screen).all(|(a, b)| (a - b).abs() < 1e-6),
        "{of_screen:?}"
    );
    let (mut by_pixels, mut by_numbers) = (PixelReader::new(), SightReader::new(scale));
    let (mut near, mut far, mut bars, mut on_target) = (0.0_f64, 0.0_f64, 0.0_f64, 0);
    for number in 0..200 {
        let chance = Chance::new(6, number);
        // Near the target as often as on the way to it.
        let part = if number % 2 == 0 { 0.05 } else { 1.0 };
        let shown = shown(
            number,
            30.0 * part * chance.uniform(0),
            part * (60.0 * chance.uniform(1) - 5.0),
        );
        let pixels = by_pixels.read(0, &shown).unwrap();
        let numbers = by_numbers.read(0, &shown).unwrap();
        let [p, n] = [pixels, numbers].map(|reading| scale.drawn(reading.target_mm));
        let apart = (p[0] - n[0]).abs().max((p[1] - n[1]).abs());
        let bar = [pixels, numbers].map(|reading| reading.to_go_mm.unwrap() * scale.bar_px_per_mm());
        // Either may have the end of the bar just outside the white line where the other has it just under it.
        let hidden = if bar.contains(&0.0) { scale.hidden_px } else { 0.0 };
        let off = (bar[0] - bar[1]).abs() - hidden;
        bars = bars.max(off);
        match n[0].hypot(n[1]) <= APART_PX {
            true => near = near.max(apart),
            false => far = far.max(apart),
        }
        assert_eq!(pixels.is_inside, numbers.is_inside, "{number}");
        on_target += usize::from(pixels.is_inside);
    }
    println!("dot {near:.2} and {far:.2} pixels apart, bar {bars:.2}; ON TARGET {on_target} times");
    // The one rounds to whole pixels, half a pixel off at most; the other finds the middle of a dot, or the end of a
    // bar, of whole pixels.
    assert!(near <= 1.0 && bars <= 1.0, "{near} {bars} pixels");
    // Where the scale is so compressed that ring and dot run together, the ring's thickest part counts with the dot.
    assert!(far <= 2.0, "{far} pixels");
    assert!((10..190).contains(&on_target), "{on_target}");
}
