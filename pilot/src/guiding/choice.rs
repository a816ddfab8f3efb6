//! The target that a person chose, the pose that she holds, and how she wishes to see the images. Nothing else changes either: no target takes the place of another
//! because the tip came nearer to it.

use bus::gather::PoseId;
use bus::message::{Chosen, Guide, ImagesWish, ToolPose, Tracked};
use scene::{Scene, Target, plan_id};

use super::Kept;

/// Why nothing is chosen, held or noted in a replay.
const REPLAYED: &str = "this run is a replay: what was chosen, held, changed and noted comes out of the recording";

/// Why nothing is chosen, held, noted, confirmed or started on a second screen.
pub(super) const ELSEWHERE: &str =
    "the run of another machine is shown here: what is chosen, held, changed, noted and confirmed is so there";

/// What is chosen among what can be.
#[derive(Debug)]
pub(super) struct Choice {
    guide: Guide,
    targets: Vec<Target>,
    kept: Kept,
}

impl Choice {
    /// What the scene chooses, from the run's epoch on; nothing until it is told where another keeps it.
    pub(super) fn of(scene: &Scene, kept: Kept) -> Self {
        let mut choice = Self {
            guide: Guide::default(),
            targets: scene.targets.clone(),
            kept,
        };
        let name = scene.guide.as_deref().filter(|_| kept == Kept::Here);
        if let Some(target) = name.and_then(|name| choice.target(name)) {
            choice.guide = choosing(choice.guide, target);
        }
        choice
    }

    pub(super) fn guide(&self) -> &Guide {
        &self.guide
    }

    /// A recording, or another machine, tells what was chosen.
    pub(super) fn heard(&mut self, guide: Guide) {
        self.guide = guide;
    }

    fn target(&self, name: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.name == name)
    }

    /// The target of this name is aimed at; none where the name is empty.
    pub(super) fn choose(&mut self, name: &str, now_ns: i64) -> Result<String, String> {
        self.may()?;
        if name.is_empty() {
            self.say(self.guide.choosing(None, 0), now_ns);
            return Ok("no target is chosen".to_owned());
        }
        let target = self.target(name).ok_or_else(|| self.unknown(name))?;
        let guide = choosing(self.guide, target);
        self.say(guide, now_ns);
        Ok(format!("chosen: {name}"))
    }

    fn unknown(&self, name: &str) -> String {
        let names: Vec<&str> = self.targets.iter().map(|target| target.name.as_str()).collect();
        match names.is_empty() {
            true => format!("there is no target {name:?}: the scene has none"),
            false => format!("there is no target {name:?}; there are {}", names.join(", ")),
        }
    }

    /// All screens hold `pose`, which must be one.
    pub(super) fn hold(&mut self, pose: &ToolPose, now_ns: i64) -> Result<String, String> {
        self.may()?;
        match pose.tracked_at(now_ns) {
            Ok(Tracked::Valid(_)) => {}
            Ok(Tracked::Lost(reason)) => return Err(format!("there is no pose to hold: {}", reason.words())),
            Err(error) => return Err(error.to_string()),
        }
        let held = PoseId {
            seq: pose.seq,
            t_capture_ns: pose.t_capture_ns,
        };
        self.say(self.guide.holding(Some(held)), now_ns);
        Ok(format!("held: pose {}", pose.seq))
    }

    /// Images look as is wished; what is not named stays.
    pub(super) fn images(&mut self, wish: ImagesWish, now_ns: i64) -> Result<String, String> {
        self.may()?;
        let images = self.guide.images().unwrap_or_default().with(wish);
        self.say(self.guide.showing(&images), now_ns);
        Ok(match images.words() {
            words if words.is_empty() => "images: as the scene says".to_owned(),
            words => format!("images: {words}"),
        })
    }

    /// Nothing is held any more.
    pub(super) fn follow(&mut self, now_ns: i64) -> Result<String, String> {
        self.may()?;
        self.say(self.guide.holding(None), now_ns);
        Ok("the tool is followed again".to_owned())
    }

    /// Words for the log.
    pub(super) fn mark(&self, words: &str) -> Result<String, String> {
        self.may()?;
        let words = words.replace(char::is_control, " ");
        match words.trim() {
            "" => Err("a mark needs words".to_owned()),
            words => Ok(format!("mark: {words}")),
        }
    }

    fn may(&self) -> Result<(), String> {
        match self.kept {
            Kept::Here => Ok(()),
            Kept::Recorded => Err(REPLAYED.to_owned()),
            Kept::Elsewhere => Err(ELSEWHERE.to_owned()),
        }
    }

    /// Stamps go up, also where the session's clock stands still: what was said later counts.
    fn say(&mut self, guide: Guide, now_ns: i64) {
        self.guide = Guide {
            t_ns: now_ns.max(self.guide.t_ns.saturating_add(1)),
            ..guide
        };
    }
}

fn choosing(guide: Guide, target: &Target) -> Guide {
    let chosen = Chosen {
        name: target.name.clone(),
        centre: target.centre,
        radius_mm: target.diameter_mm / 2.0,
        entry: target.entry,
        stop_mm: target.stop_mm,
    };
    guide.choosing(Some(&chosen), plan_id(target))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::Lost;
    use geometry::Rigid;
    use std::path::Path;

    /// Names of 40 bytes that differ in the last character only, which is of several bytes.
    const LONG: [&str; 2] = [
        "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaé",
        "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaè",
    ];

    fn scene(guide: &str) -> Scene {
        let [a, b] = LONG;
        let text = format!(
            "{guide}\n[[targets]]\nname = \"near\"\nct_mm = [0, 0, 0]\n[[targets]]\nname = \"far\"\nct_mm = [90, 0, 0]\n\
             stop_mm = 4\n[[targets]]\nname = \"{a}\"\nct_mm = [1, 1, 1]\n[[targets]]\nname = \"{b}\"\nct_mm = [2, 2, 2]"
        );
        Scene::parse(&text, Path::new("s.toml")).unwrap()
    }

    fn name(choice: &Choice) -> Option<String> {
        choice.guide().chosen().unwrap().map(|chosen| chosen.name)
    }

    fn valid(seq: u64) -> ToolPose {
        let mut pose = ToolPose {
            seq,
            t_capture_ns: 50,
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(Rigid::identity()));
        pose
    }

    #[test]
    fn the_scene_chooses_first_and_then_a_person() {
        let mut choice = Choice::of(&scene("[guide]\ntarget = \"far\""), Kept::Here);
        assert_eq!((name(&choice).as_deref(), choice.guide().t_ns), (Some("far"), 0));
        let chosen = choice.guide().chosen().unwrap().unwrap();
        assert_eq!(
            (chosen.centre.mm(), chosen.radius_mm, chosen.stop_mm),
            ([90.0, 0.0, 0.0], 2.5, 4.0)
        );
        assert_ne!(choice.guide().plan_id, 0);
        choice.choose("near", 100).unwrap();
        assert_eq!((name(&choice).as_deref(), choice.guide().t_ns), (Some("near"), 100));
        choice.choose("", 200).unwrap();
        assert_eq!((name(&choice), choice.guide().plan_id), (None, 0));
        assert_eq!(name(&Choice::of(&scene(""), Kept::Here)), None);
    }

    #[test]
    fn a_name_that_no_target_has_changes_nothing_and_is_answered_with_those_that_there_are() {
        let mut choice = Choice::of(&scene("[guide]\ntarget = \"far\""), Kept::Here);
        let before = *choice.guide();
        for unknown in ["Near", "near ", "nea", &LONG[0][..38], "\u{fffd}"] {
            let said = choice.choose(unknown, 100).unwrap_err();
            assert!(said.contains("there are near, far, a"), "{said}");
        }
        assert_eq!(*choice.guide(), before);
        let bare = Scene::parse("[volume]\nsource = \"a.nii\"", Path::new("s.toml")).unwrap();
        let said = Choice::of(&bare, Kept::Here).choose("near", 1).unwrap_err();
        assert!(said.contains("the scene has none"), "{said}");
    }

    /// Over the bus, as a window would ask.
    #[test]
    fn names_that_differ_in_their_last_byte_are_told_apart() {
        use bus::message::{Command, CommandKind};
        let mut choice = Choice::of(&scene(""), Kept::Here);
        for long in LONG {
            let asked = Command::with_text(CommandKind::Choose, long).words();
            choice.choose(&asked, 1).unwrap();
            assert_eq!(name(&choice).as_deref(), Some(long));
        }
    }

    #[test]
    fn only_a_valid_pose_is_held_and_what_is_chosen_stays() {
        let mut choice = Choice::of(&scene("[guide]\ntarget = \"far\""), Kept::Here);
        let mut lost = valid(7);
        lost.set(Tracked::Lost(Lost::NotSeen));
        assert!(choice.hold(&lost, 100).unwrap_err().contains("marker not seen"));
        let mut none = valid(7);
        none.q[0] = f64::NAN;
        assert!(choice.hold(&none, 100).is_err());
        // From the future: nobody can have seen it.
        assert!(choice.hold(&valid(7), -100_000_000).is_err());
        assert_eq!(choice.guide().held(), None);
        choice.hold(&valid(7), 100).unwrap();
        assert_eq!(
            choice.guide().held(),
            Some(PoseId {
                seq: 7,
                t_capture_ns: 50
            })
        );
        assert_eq!(name(&choice).as_deref(), Some("far"));
        choice.choose("near", 101).unwrap();
        assert_eq!(choice.guide().held().map(|held| held.seq), Some(7));
        choice.follow(102).unwrap();
        assert_eq!((choice.guide().held(), name(&choice).as_deref()), (None, Some("near")));
    }

    #[test]
    fn images_look_as_wished_until_the_scene_is_asked_for_again() {
        use bus::message::Change;
        let bone = scene::WindowLevel::named("bone").unwrap();
        let mut choice = Choice::of(&scene("[guide]\ntarget = \"far\""), Kept::Here);
        let wish = |field_mm, window| ImagesWish {
            field_mm,
            window,
            at_rest: Change::Keep,
        };
        let said = choice.images(wish(Change::Keep, Change::Set(bone)), 10).unwrap();
        assert_eq!(said, "images: W 2000 C 400");
        let said = choice.images(wish(Change::Set(60.0), Change::Keep), 20).unwrap();
        assert_eq!(said, "images: W 2000 C 400, field 60 mm");
        choice.choose("near", 30).unwrap();
        let images = choice.guide().images().unwrap();
        assert_eq!((images.field_mm, images.window), (Some(60.0), Some(bone)));
        let said = choice.images(wish(Change::Scene, Change::Scene), 40).unwrap();
        assert_eq!((said.as_str(), choice.guide().t_ns), ("images: as the scene says", 40));
        assert_eq!(name(&choice).as_deref(), Some("near"));
    }

    #[test]
    fn stamps_go_up_although_the_clock_stands() {
        let mut choice = Choice::of(&scene(""), Kept::Here);
        let mut stamps = vec![choice.guide().t_ns];
        for name in ["near", "far", ""] {
            choice.choose(name, 0).unwrap();
            stamps.push(choice.guide().t_ns);
        }
        assert_eq!(stamps, [0, 1, 2, 3]);
    }

    #[test]
    fn in_a_replay_nobody_chooses() {
        let mut choice = Choice::of(&scene("[guide]\ntarget = \"far\""), Kept::Recorded);
        assert_eq!(name(&choice), None);
        let refused = [
            choice.choose("near", 1),
            choice.hold(&valid(1), 100),
            choice.follow(1),
            choice.mark("x"),
            choice.images(ImagesWish::default(), 1),
        ];
        for said in refused {
            assert!(said.unwrap_err().contains("replay"));
        }
        assert_eq!(*choice.guide(), Guide::default());
    }

    #[test]
    fn marks_have_words_on_one_line() {
        let choice = Choice::of(&scene(""), Kept::Here);
        assert_eq!(choice.mark("first\nincision").unwrap(), "mark: first incision");
        assert!(choice.mark(" \t").is_err());
    }
}
