//! A cable that is out, seen on the second screen: its images grow old by the first machine's clock, and are of the present again.

use std::time::{Duration, Instant};

use bus::clock::{ms, ns};
use bus::message::{Ages, FrameState, Lost};
use bus::port::FrameSubscriber;
use bus::session::Session;
use bus::topic::VIEW_FRAME;

use crate::both::{Both, Looking, pilot, programs, small};
use crate::rig::{alone, until, world};

/// Poses must be there again within 1 s, which docs/remote.md holds beside what was measured. A machine of two cores with a dozen
/// programs in debug takes its time, so the test asks for this.
const BACK: Duration = Duration::from_secs(10);

/// A view of the second screen, as its window judges it.
struct Screen {
    session: Session,
    frames: FrameSubscriber,
    newest: Option<bus::port::Frame>,
    ages: Ages,
}

impl Screen {
    fn of(far: &Looking) -> Self {
        let view = &far.scene.views[0].name;
        Self {
            session: Session::open(&far.bus, &far.run).unwrap(),
            frames: FrameSubscriber::open(&far.bus, &VIEW_FRAME, view).unwrap(),
            newest: None,
            ages: Ages::of(&far.scene.limits),
        }
    }

    /// What the image on the screen may claim now.
    fn state(&mut self) -> Option<FrameState> {
        self.session.follow().unwrap();
        if let Some(frame) = self.frames.newest().unwrap() {
            self.newest = Some(frame);
        }
        let now_ns = self.session.clock().now_ns();
        self.newest.as_ref()?.shown(now_ns, self.ages).state
    }

    /// As its renderer drew it.
    fn drawn(&self) -> Option<FrameState> {
        self.newest.as_ref()?.header().stamp.frame_state()
    }
}

/// `TROCAR_CUT_S` cuts for longer than 3 s; how long the way back took is printed.
#[test]
fn images_of_a_screen_that_is_cut_off_are_stale_in_time_and_live_again_after_it() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let world = world();
    let both = Both::start(world.path(), &programs, &[&small(world.path())]);
    let mut screen = Screen::of(&both.far);
    until("an image of the present", || {
        (screen.state()? == FrameState::Live).then_some(())
    });
    let cut_s: f64 = std::env::var("TROCAR_CUT_S")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(3.0);
    both.wire.stand_still(true);
    let cut = Instant::now();
    let (mut stale_ms, mut lost_ms) = (None, None);
    while cut.elapsed().as_secs_f64() < cut_s {
        // Before the look, so that the time that it takes is not held against the image.
        let since = cut.elapsed();
        let state = screen.state().unwrap();
        // Whatever came was measured before the cut, and the clock here is never behind the true one: no margin is needed.
        if ns(since) > screen.ages.stale_ns {
            assert_ne!(state, FrameState::Live, "{} ms after the cut", since.as_millis());
        }
        if ns(since) > screen.ages.lost_ns {
            assert!(
                matches!(state, FrameState::Lost(_)),
                "{state:?}, {} ms",
                since.as_millis()
            );
        }
        if state != FrameState::Live {
            stale_ms.get_or_insert(since.as_millis());
        }
        if state == FrameState::Lost(Lost::Silent) {
            lost_ms.get_or_insert(since.as_millis());
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    // So does the renderer by itself, whoever looks.
    until("an image without a pose", || {
        screen.state();
        (screen.drawn()? == FrameState::Lost(Lost::Silent)).then_some(())
    });
    let status = pilot(world.path(), &programs, &["status", "--run", "second"]);
    let status = { status }.output().unwrap();
    let words = String::from_utf8_lossy(&status.stdout).into_owned();
    assert!(words.contains("NO ANSWER for"), "{words}");

    let last = screen.newest.as_ref().unwrap().header().stamp.t_capture_ns;
    both.wire.stand_still(false);
    let mended = Instant::now();
    until("an image of the present again", || {
        let state = screen.state()?;
        let stamp = screen.newest.as_ref()?.header().stamp;
        (state == FrameState::Live && stamp.t_capture_ns > last).then_some(())
    });
    let back = mended.elapsed();
    println!(
        "stale {stale_ms:?} ms and without a pose {lost_ms:?} ms after the cut (limits {} and {} ms), which lasted {cut_s} s; live again \
         {:.0} ms after it",
        ms(screen.ages.stale_ns),
        ms(screen.ages.lost_ns),
        back.as_secs_f64() * 1e3
    );
    assert!(back < BACK, "{back:?}\n{}", both.said());
}
