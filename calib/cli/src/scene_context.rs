//! The scene that a result is made for: its gates, its names and, of a run that is going, its CT.

use std::cell::OnceCell;
use std::path::PathBuf;

use bus::Bus;
use bus::port::VolumeSubscriber;
use bus::run::{RunContext, RunError, RunLock, run_dir};
use clap::Args;
use geometry::{Ct, Point, VolumeGrid};
use scene::Scene;
use scene::tracking::{CalibrationGates, RegistrationLink};

use crate::live::LiveError;
use crate::values::Name;

/// The volume of a run is shown to whoever joins within this, ns.
const VOLUME_NS: i64 = 2_000_000_000;
/// Between two looks, ns.
const LOOK_NS: i64 = 5_000_000;

/// Whose gates hold where the command line gives none.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct SceneArgs {
    /// Hold the result against the gates of this scene, and its names against the scene's
    #[arg(long, value_name = "SCENE.toml", conflicts_with = "live")]
    pub(crate) scene: Option<PathBuf>,
    /// The same of a run that is going; poses and touches are then those of its instrument, and the CT is its own
    #[arg(long, visible_alias = "run", value_name = "RUN")]
    pub(crate) live: Option<String>,
}

/// A scene that a result is made for.
pub(crate) struct SceneContext {
    pub(crate) scene: Scene,
    /// The run that it is of, where that is going.
    pub(crate) going: Option<Going>,
    /// `run NAME`, or the file.
    of: String,
    examined: OnceCell<Option<Examined>>,
}

/// A run that is going.
pub(crate) struct Going {
    pub(crate) name: String,
    pub(crate) dir: PathBuf,
    pub(crate) bus: Bus,
}

/// What the volume of a run says.
pub(crate) struct Examined {
    pub(crate) hash: String,
    pub(crate) grid: VolumeGrid,
}

impl SceneContext {
    /// The scene that the command line names; `None` where it names none.
    pub(crate) fn open(args: &SceneArgs) -> Result<Option<Self>, LiveError> {
        match (&args.live, &args.scene) {
            (Some(name), _) => Self::of_run(name).map(Some),
            (None, Some(path)) => Ok(Some(Self {
                scene: Scene::load(path)?,
                going: None,
                of: path.display().to_string(),
                examined: OnceCell::new(),
            })),
            (None, None) => Ok(None),
        }
    }

    fn of_run(name: &str) -> Result<Self, LiveError> {
        let dir = run_dir(name)?;
        if !RunLock::is_held(&dir) {
            let name = name.to_owned();
            return Err(RunError::NotRunning { name }.into());
        }
        let context = RunContext::load(&dir)?;
        let (name, bus) = (name.to_owned(), Bus::join(&context)?);
        Ok(Self {
            scene: Scene::load(&context.scene_path())?,
            of: format!("run {name}"),
            examined: OnceCell::new(),
            going: Some(Going { name, dir, bus }),
        })
    }

    /// `TABLE of run NAME`: where a gate is from.
    pub(crate) fn table(&self, table: &str) -> String {
        format!("{table} of {}", self.of)
    }

    /// The tool's name: the scene's, which `given` must be where it is given.
    pub(crate) fn tool(&self, given: Option<&Name>) -> Result<Name, LiveError> {
        let own = self.own("tool", given, Some(&self.scene.tool.name))?;
        Ok(own.unwrap_or_else(|| Name::told("tool")))
    }

    /// The marker's name: the one that the scene asks of calibrations, where it does.
    pub(crate) fn marker(&self, given: Option<&Name>) -> Result<Name, LiveError> {
        let link = self.scene.tracker.links.calibration.as_ref();
        let own = self.own("marker", given, link.and_then(|link| link.file.marker.as_deref()))?;
        Ok(own.unwrap_or_else(|| Name::told("marker")))
    }

    /// A word of the scene, which `given` must be where both are there.
    pub(crate) fn own(
        &self,
        what: &'static str,
        given: Option<&Name>,
        own: Option<&str>,
    ) -> Result<Option<Name>, LiveError> {
        match (given, own) {
            (Some(given), Some(own)) if given.as_str() != own => Err(LiveError::Other {
                of: self.of.clone(),
                what,
                given: given.as_str().to_owned(),
                expected: own.to_owned(),
            }),
            (given, own) => Ok(given.cloned().or_else(|| own.map(Name::told))),
        }
    }

    /// The hash of the run's CT, which `given` must be where it is given; `None` where neither is known.
    pub(crate) fn ct_hash(&self, given: Option<&Name>) -> Result<Option<Name>, LiveError> {
        let own = self.examined()?.map(|examined| examined.hash.as_str());
        self.own("ct-hash", given, own)
    }

    /// The marker that registrations must be of, where the scene says so.
    pub(crate) fn registered_marker(&self, given: Option<&Name>) -> Result<Option<Name>, LiveError> {
        let own = self.registration().and_then(|link| link.file.marker.as_deref());
        self.own("marker", given, own)
    }

    /// The gates for calibrations.
    pub(crate) fn calibration_gates(&self) -> CalibrationGates {
        let link = self.scene.tracker.links.calibration.as_ref();
        link.map(|link| link.gates).unwrap_or_default()
    }

    /// What the scene says of its registration.
    pub(crate) fn registration(&self) -> Option<&RegistrationLink> {
        self.scene.tracker.links.registration.as_ref()
    }

    /// The frame that the patient is registered from: that of the marker on the patient, where the scene has one.
    pub(crate) fn registered_from(&self) -> &'static str {
        match self.scene.tracker.source.has_reference() {
            true => "reference",
            false => "tracker",
        }
    }

    /// That the tracker of this scene will not use a registration from this frame, where it is so.
    pub(crate) fn unused_from(&self, from: &str) -> Option<String> {
        let expected = self.registered_from();
        (from != expected).then(|| {
            format!(
                "WARNING: found a registration from {from}, expected one from {expected}: the tracker of {} will not use it",
                self.of
            )
        })
    }

    /// The volume of the run; `None` without a run, or where it is not there yet.
    pub(crate) fn examined(&self) -> Result<Option<&Examined>, LiveError> {
        if self.examined.get().is_none() {
            // Set once: nobody else is there to set it.
            let _ = self.examined.set(self.examine()?);
        }
        Ok(self.examined.get().and_then(Option::as_ref))
    }

    fn examine(&self) -> Result<Option<Examined>, LiveError> {
        let Some(going) = &self.going else { return Ok(None) };
        let volumes = VolumeSubscriber::open(&going.bus)?;
        let clock = going.bus.clock();
        let until = clock.now_ns().saturating_add(VOLUME_NS);
        loop {
            if let Some(volume) = volumes.poll()? {
                return Ok(Some(Examined {
                    hash: volume.hash().to_string(),
                    grid: *volume.grid(),
                }));
            }
            if clock.now_ns() >= until {
                return Ok(None);
            }
            clock.sleep_until(clock.now_ns() + LOOK_NS);
        }
    }

    /// Where an error counts, as the tracker has it: at the first target, else in the middle of the volume.
    pub(crate) fn target(&self) -> Result<Option<Point<Ct>>, LiveError> {
        match self.scene.targets.first() {
            Some(target) => Ok(Some(target.centre)),
            None => Ok(self.examined()?.map(|examined| examined.grid.centre())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nobody was told before the tracker had it.
    #[test]
    fn a_registration_that_the_scene_will_not_use_is_warned_of() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        let of = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let args = SceneArgs {
                scene: Some(path.clone()),
                live: None,
            };
            SceneContext::open(&args).unwrap().unwrap()
        };
        let room = "[tracker]\nsource = \"operating-room\"\n";
        let plain = of(room);
        assert!(plain.unused_from("tracker").is_none() && plain.unused_from("reference").is_some());
        let marked = of(&format!("{room}[tracker.room.reference]\ncone_deg = 80.0\n"));
        assert!(marked.unused_from("reference").is_none());
        let said = marked.unused_from("tracker").unwrap();
        assert!(
            said.contains("found a registration from tracker, expected one from reference"),
            "{said}"
        );
    }
}
