//! The overview that is turned by dragging: many steps become few requests, one at a time, each with the whole of what is wished.

use std::f64::consts::{FRAC_PI_2, TAU};

use bus::message::Command;
use bus::port::{CommandClient, Pending};
use geometry::VolumeGrid;
use scene::Scene;

/// A drag over so many pixels turns by a radian.
const PIXELS_PER_RAD: f64 = 120.0;

/// How one view of the scene is turned from what the scene says.
#[derive(Debug, Default)]
pub(super) struct Turning {
    view: usize,
    /// Further round, further up, radians.
    by: [f64; 2],
    /// It was turned, or turned back, since it was asked for last.
    is_moved: bool,
    open: Option<Pending>,
}

impl Turning {
    /// A step of a drag, pixels to the right and downwards: what is near the viewer goes with the pointer.
    pub(super) fn drag(&mut self, view: usize, [right_px, down_px]: [i32; 2], scene: &Scene) {
        if self.view != view {
            (self.view, self.by) = (view, [0.0; 2]);
        }
        let stands = scene.views.get(view).map_or(0.0, |view| view.surface.elevation_rad);
        let [round, up] = &mut self.by;
        *round = (*round - f64::from(right_px) / PIXELS_PER_RAD) % TAU;
        // Beyond the head and the feet the patient would be upside down.
        let most = [-FRAC_PI_2 - stands, FRAC_PI_2 - stands];
        *up = (*up + f64::from(down_px) / PIXELS_PER_RAD).clamp(most[0], most[1]);
        self.is_moved = true;
    }

    /// As the scene says again.
    pub(super) fn back(&mut self, view: usize) {
        (self.view, self.by, self.is_moved) = (view, [0.0; 2], true);
    }

    /// What is to be asked for now.
    fn next(&mut self, grid: Option<&VolumeGrid>, scene: &Scene) -> Result<Option<Command>, String> {
        if !std::mem::take(&mut self.is_moved) {
            return Ok(None);
        }
        let (Some(view), Ok(index)) = (scene.views.get(self.view), u32::try_from(self.view)) else {
            return Ok(None);
        };
        if self.by == [0.0; 2] {
            return Ok(Some(Command::turn(index, None)));
        }
        let grid = grid.ok_or("the overview cannot be turned before there is an examination")?;
        let camera = view.surface.turned(self.by, grid, view.size);
        let camera = camera.map_err(|error| error.to_string())?;
        Ok(Some(Command::turn(index, Some(&camera))))
    }

    /// Takes the answer that has come, and asks for what is wished; again and again.
    ///
    /// # Errors
    /// In words, why it was refused or has no answer.
    pub(super) fn turn(
        &mut self,
        renderer: &CommandClient,
        (grid, scene): (Option<&VolumeGrid>, &Scene),
        patience_ns: i64,
    ) -> Result<(), String> {
        if let Some(pending) = &self.open {
            let answer = match pending.reply() {
                Ok(None) if pending.waited_ns() <= patience_ns => return Ok(()),
                Ok(Some(reply)) if !reply.refused => Ok(()),
                Ok(Some(reply)) => Err(reply.text),
                Ok(None) => Err(pending.no_answer().to_string()),
                Err(error) => Err(error.to_string()),
            };
            self.open = None;
            answer?;
        }
        if let Some(command) = self.next(grid, scene)? {
            self.open = Some(super::send(renderer, command)?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Affine, letters};
    use std::path::Path;

    fn scene() -> Scene {
        let text = "[[views]]\nname = \"overview\"\nplane = \"surface\"\nextent = \"global\"\nsize = [200, 200]\n";
        Scene::parse(text, Path::new("s.toml")).unwrap()
    }

    fn grid() -> VolumeGrid {
        let affine = Affine::from_rows([[1.0, 0.0, 0.0, -60.0], [0.0, 1.0, 0.0, -40.0], [0.0, 0.0, 2.0, 0.0]]);
        VolumeGrid::checked([120, 80, 100], affine).unwrap()
    }

    fn seen_from(turning: &mut Turning) -> String {
        let command = turning.next(Some(&grid()), &scene()).unwrap().unwrap();
        let (plane, _) = command.plane.asked([200, 200]).unwrap();
        letters(-plane.into_screen()).to_string()
    }

    /// Seen from the front, the patient's left is at the right: it comes to the front as it is pulled to the left.
    #[test]
    fn what_is_near_the_viewer_goes_with_the_pointer() {
        let quarter = (PIXELS_PER_RAD * FRAC_PI_2).round() as i32;
        let mut turning = Turning::default();
        turning.drag(0, [-quarter, 0], &scene());
        assert_eq!(seen_from(&mut turning), "L");
        // Pulled down as far as it goes and further: from the head.
        turning.drag(0, [quarter, i32::MAX], &scene());
        assert_eq!(seen_from(&mut turning), "S");
        turning.drag(0, [0, i32::MIN], &scene());
        assert_eq!(seen_from(&mut turning), "I");
    }

    #[test]
    fn many_steps_are_one_request_and_the_way_back_is_the_scenes() {
        let mut turning = Turning::default();
        assert!(turning.next(Some(&grid()), &scene()).unwrap().is_none());
        (0..50).for_each(|_| turning.drag(0, [3, 1], &scene()));
        let asked = turning.next(Some(&grid()), &scene()).unwrap().unwrap();
        assert_ne!(asked, Command::turn(0, None));
        assert!(
            turning.next(Some(&grid()), &scene()).unwrap().is_none(),
            "it was asked for"
        );
        turning.back(0);
        assert_eq!(turning.next(None, &scene()).unwrap(), Some(Command::turn(0, None)));
        turning.drag(0, [3, 1], &scene());
        assert!(
            turning
                .next(None, &scene())
                .unwrap_err()
                .contains("before there is an examination")
        );
    }
}
