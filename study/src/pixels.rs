//! A reader that looks at the screen: a frame of the operator's window, painted into memory, and of that nothing but
//! pixels.
//!
//! Where the drawing lies is known, as a person knows her screen. In it the target's dot is found by its colour, and
//! the place of its middle goes back through the scale; the way to go is the filled part of the bar; ON TARGET is the
//! colour of the verdict's band.
//!
//! A frame that cannot be painted is no picture that shows nothing: [`PixelReader::painted`] tells of it, and what was read
//! with such a reader says nothing of the display.

use std::path::Path;

use bus::gather::{PoseId, Set};
use bus::message::{Chosen, FrameHeader, FrameStamp, Guide, ImagePlane, ToolPose, Tracked, VolumeHash, Workflow};
use geometry::{Affine, Ct, Direction, Rigid, Tool, VolumeGrid};
use guidance::sight::Covariance;
use guidance::workflow::Stage;
use hand::{Reader, Reading, Shown, upright_axes};
use picture::{Rgb, palette};
use scene::Scene;
use window::colours;
use window::frame::Frames;
use window::model::{Known, Model};
use window::screen::{self, Dial, Look};
use window::sizes::{Screen, Sizes};

use crate::Words;

/// A monitor of 24 inches.
pub const SCREEN: Screen = Screen {
    pixels: [1920, 1080],
    pixel_mm: 531.0 / 1920.0,
};
/// Images beside the sight, as in a scene that says nothing of views.
const IMAGES: usize = 7;
/// When the pose was captured, ns; what is shown is 20 ms old.
const CAPTURED_NS: i64 = 5_000_000_000;
const NOW_NS: i64 = CAPTURED_NS + 20_000_000;
const VOLUME: VolumeHash = VolumeHash([0x36; 32]);

/// How coarse that screen's sight is, for [`hand::SightReader`]; `None` where the screen is too small for words.
pub fn dial(screen: Screen) -> Option<hand::Dial> {
    Sizes::of(screen, IMAGES).map(|sizes| scale(&Dial::of(&sizes)))
}

fn scale(dial: &Dial) -> hand::Dial {
    hand::Dial {
        rim_px: dial.rim_px,
        bar_px: f64::from(dial.bar.height()),
        hidden_px: dial.hidden_px,
    }
}

/// The window's screen of seven images and the sight, and who reads it.
pub struct PixelReader {
    frames: Frames,
    memory: Vec<u32>,
    scene: Scene,
    grid: VolumeGrid,
    dial: Dial,
    scale: hand::Dial,
    seq: u64,
    failed: Option<String>,
}

impl PixelReader {
    /// On [`SCREEN`].
    ///
    /// # Errors
    /// In words, where there is no such screen.
    pub fn new() -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let [width, height] = SCREEN.pixels.map(|n| n as usize);
        let spaced = Affine::from_rows([
            [1.0, 0.0, 0.0, -200.0],
            [0.0, 1.0, 0.0, -200.0],
            [0.0, 0.0, 1.0, -200.0],
        ]);
        let sizes = Sizes::of(SCREEN, IMAGES).ok_or("the screen is too small for the window")?;
        let dial = Dial::of(&sizes);
        Ok(Self {
            frames: Frames::default(),
            memory: vec![0; width * height],
            scene: Scene::parse("", Path::new("")).map_err(|error| error.to_string())?,
            grid: VolumeGrid::checked([400; 3], spaced).map_err(|error| error.to_string())?,
            scale: scale(&dial),
            dial,
            seq: 0,
            failed: None,
        })
    }

    /// Whether all that was to be read was painted: asked when the reading is done.
    ///
    /// # Errors
    /// Why the first frame that was not painted was not.
    pub fn painted(&self) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        match &self.failed {
            None => Ok(()),
            Some(why) => Err(format!("a frame of the window was not painted: {why}").into()),
        }
    }

    /// Paints the screen of what is shown.
    fn paint(&mut self, shown: &Shown) -> Result<(), Words> {
        self.seq += 1;
        let pose = message(shown, self.seq);
        let views = self.scene.views.iter();
        let headers: Result<Vec<_>, Words> = views.map(|view| self.header(view, shown).map(Some)).collect();
        let headers = headers?;
        let guide = Guide::default().choosing(Some(&chosen(shown)), 7);
        let known = Known {
            scene: &self.scene,
            now_ns: NOW_NS,
            headers: &headers,
            set: Some(Set::One(PoseId {
                seq: self.seq,
                t_capture_ns: CAPTURED_NS,
            })),
            poses: &[pose],
            guide: Some(guide),
            workflow: Some(navigating()?),
            steps: None,
            identity: None,
            volume: Some(VOLUME),
            recorder: None,
            watched_ns: None,
            may_restart_localizer: false,
            is_replay: false,
            law: None,
            timeline: None,
            recorded_in: None,
            is_simulated: false,
            began_ns: Some(0),
        };
        let (model, look) = (Model::of(&known), Look::default());
        let time_s = self.seq as f64 / 60.0;
        self.frames
            .paint_ui(SCREEN, (Vec::new(), time_s), &[], &mut self.memory, |ui| {
                screen::show(ui, &model, SCREEN, &look)
            })?;
        Ok(())
    }

    fn header(&self, view: &scene::View, shown: &Shown) -> Result<FrameHeader, Words> {
        let plane = slice_view_proc::plane(view, &self.grid, &shown.pose)?;
        let [width, height] = view.size;
        Ok(FrameHeader {
            stamp: FrameStamp {
                seq: self.seq,
                t_capture_ns: CAPTURED_NS,
                volume_hash: VOLUME.0,
                ..FrameStamp::default()
            },
            plane: ImagePlane::of(Some(&plane), view.window),
            width,
            height,
        })
    }

    /// The colour at a pixel of the screen; `None` beside it.
    fn colour(&self, x: i64, y: i64) -> Option<Rgb> {
        let width = usize::try_from(SCREEN.pixels[0]).ok()?;
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        let at = (x < width).then(|| y * width + x)?;
        let [_, r, g, b] = self.memory.get(at)?.to_be_bytes();
        Some(Rgb(r, g, b))
    }

    /// The middle of the target's dot, pixels right and up of the drawing's middle: the mean of the places about which
    /// all is of the target's colour as far as most of the dot reaches. No line of that colour is so wide.
    fn dot(&self) -> Option<[f64; 2]> {
        let room = self.dial.room;
        let core = 0.7 * self.dial.dot_px;
        let reach = core.floor() as i64;
        let within = |(dx, dy): (i64, i64)| ((dx * dx + dy * dy) as f64).sqrt() <= core;
        let disc: Vec<(i64, i64)> = (-reach..=reach)
            .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
            .filter(|at| within(*at))
            .collect();
        let is_target = |x: i64, y: i64| self.colour(x, y) == Some(palette::TARGET);
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for y in room.top().ceil() as i64 + reach..room.bottom() as i64 - reach {
            for x in room.left().ceil() as i64 + reach..room.right() as i64 - reach {
                if is_target(x, y) && disc.iter().all(|(dx, dy)| is_target(x + dx, y + dy)) {
                    sum = [sum[0] + x as f64 + 0.5, sum[1] + y as f64 + 0.5];
                    count += 1.0;
                }
            }
        }
        let middle = room.center();
        let right = sum[0] / count - f64::from(middle.x);
        let down = sum[1] / count - f64::from(middle.y);
        (count > 0.0).then_some([right, -down])
    }

    /// What of the bar is filled above zero, pixels; below zero negative.
    fn filled(&self) -> f64 {
        let bar = self.dial.bar;
        let zero = f64::from(bar.bottom()) - self.dial.below_zero * f64::from(bar.height());
        let x = f64::from(bar.center().x) as i64;
        let rows = bar.top().round() as i64..bar.bottom().round() as i64;
        let grounds = [
            of(colours::CELL.to_array()),
            of(colours::LINE.to_array()),
            Rgb(255, 255, 255),
        ];
        // Nearer to the ink than to all that the bar is drawn on: pixels at its end are mixed.
        let is = |y: i64, ink: Rgb| {
            self.colour(x, y).is_some_and(|found| {
                grounds
                    .iter()
                    .all(|ground| distance(found, ink) < distance(found, *ground))
            })
        };
        let top = rows.clone().find(|y| is(*y, palette::TUBE));
        let bottom = rows.rev().find(|y| is(*y, palette::WARN));
        match (top, bottom) {
            (Some(y), _) => zero - y as f64,
            (None, Some(y)) => zero - (y + 1) as f64,
            (None, None) => 0.0,
        }
    }

    /// The band of the verdict has the colour that ON TARGET alone has; left of the words.
    fn is_on_target(&self) -> bool {
        let verdict = self.dial.verdict;
        self.colour(verdict.left() as i64 + 6, verdict.center().y as i64) == Some(palette::TARGET)
    }
}

impl Reader for PixelReader {
    fn pictures(&self, _: &Shown) -> Vec<usize> {
        vec![0]
    }

    fn axes(&self, _: usize, pose: Rigid<Ct, Tool>) -> [Direction<Ct>; 2] {
        upright_axes(pose * Direction::<Tool>::Z)
    }

    fn read(&mut self, _: usize, shown: &Shown) -> Option<Reading> {
        if let Err(why) = self.paint(shown) {
            self.failed.get_or_insert(why.to_string());
            return None;
        }
        Some(Reading {
            target_mm: self.scale.read(self.dot()?),
            axis: [0.0; 2],
            to_go_mm: Some(self.scale.to_go(self.filled())),
            // Asked for on displays of several pictures only.
            room_mm: 0.0,
            is_inside: self.is_on_target(),
        })
    }

    fn unseen_mm(&self, _: &Shown) -> f64 {
        0.0
    }
}

fn message(shown: &Shown, seq: u64) -> ToolPose {
    let mut pose = ToolPose {
        seq,
        t_capture_ns: CAPTURED_NS,
        t_publish_ns: CAPTURED_NS,
        flags: ToolPose::TIP_KNOWN,
        ..ToolPose::EMPTY
    };
    pose.set(Tracked::Valid(shown.pose));
    match shown.covariance {
        Covariance::Upper(upper) => pose.covariance = upper,
        Covariance::Exact => pose.flags |= ToolPose::NOISELESS,
        Covariance::Missing => pose.flags &= !ToolPose::TIP_KNOWN,
    }
    pose
}

fn chosen(shown: &Shown) -> Chosen {
    Chosen {
        name: "target".to_owned(),
        centre: shown.aim.target,
        radius_mm: shown.aim.radius_mm,
        entry: shown.aim.entry,
        stop_mm: shown.aim.stop_mm,
    }
}

fn navigating() -> Result<Workflow, Words> {
    let stage = Stage::ALL.iter().position(|stage| *stage == Stage::Navigating);
    Ok(Workflow {
        stage: stage.ok_or("there is no stage in which one navigates")? as u32,
        flags: Workflow::RESEARCH | Workflow::SIGHT | Workflow::IMAGES,
        ..Workflow::default()
    })
}

/// A colour of the screen, opaque.
fn of([r, g, b, _]: [u8; 4]) -> Rgb {
    Rgb(r, g, b)
}

fn distance(Rgb(r, g, b): Rgb, Rgb(x, y, z): Rgb) -> u32 {
    let square = |a: u8, b: u8| u32::from(a.abs_diff(b)).pow(2);
    square(r, x) + square(g, y) + square(b, z)
}

#[cfg(test)]
mod tests;
