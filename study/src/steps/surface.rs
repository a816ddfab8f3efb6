//! The registration by the bone's surface, as a tracked ultrasound probe sees it: each step is a command of `calib` on files.
//!
//! ```text
//! emitters' frames -> probe-marker.json -+-> wires.mha, wires.csv -> probe.json -+
//!                                        +-> sweep.mha -> seen.csv -------------+-> registration.json, or refused.json
//! landmarks.csv -> guess.json --------------------------------------------------+
//! ```

use std::fs;

use calib::file::{Registered, RegistrationFile};
use calib_cli::REFUSED_FORMAT;
use chance::{Chance, mix};
use geometry::{Ct, Image, Point, Reference, Rigid, Tool};
use phantom::Landmark;
use scene::operating_room::{Array, Probe as Spec};
use tracker_proc::probe::SimulatedProbe;

use super::sequence::Tracked;
use super::wires::Wires;
use super::{Misplaced, Prepared, Refused, Step, Work, listed};
use crate::Words;
use crate::images::Examined;
use crate::patient::patient;
use crate::plan::Surface;
use crate::room::{PROBE, TrueRoom};
use crate::sounding::places;

/// What is drawn, by number.
const ROOM: u64 = 20;
const WIRES: u64 = 21;
const SPEED: u64 = 22;
const LANDMARKS: u64 = 23;
const HAND: u64 = 24;
/// A curved array for bone that lies deep.
const RADIUS_MM: f64 = 60.0;
const HALF_ANGLE_RAD: f64 = 0.5;
const DEPTH_MM: f64 = 80.0;
const PIXEL_MM: f64 = 0.25;
/// Landmarks of the rough guess, by number among the places of the beads on the skin.
const GUESSED: [usize; 4] = [0, 3, 5, 6];
/// What is told of the guess: its turn, and how far it is off at the points, for each mm of a landmark and at least.
const GUESS_DEG: &str = "20";
const GUESS_TIMES: f64 = 4.0;
const LEAST_GUESS_MM: f64 = 10.0;
/// Images a second; each is of a place of its own, and the time between them is of no matter.
const RATE_HZ: f64 = 15.0;

/// The probe as it truly is.
struct TrueProbe {
    simulated: SimulatedProbe,
    tool_from_image: Rigid<Tool, Image>,
    size_px: [usize; 2],
    /// The middle of the face in the image, mm.
    face_mm: [f64; 2],
}

impl TrueProbe {
    /// In tissue whose sound is so many times as fast as the scanner takes it for.
    fn new(speed_ratio: f64, seed: u64) -> Result<Self, Words> {
        let spec = Spec {
            array: Array::Convex {
                radius_mm: RADIUS_MM,
                half_angle_rad: HALF_ANGLE_RAD,
            },
            depth_mm: DEPTH_MM,
            pixel_mm: PIXEL_MM,
            rate_hz: RATE_HZ,
            lag_s: 0.0,
            speed_ratio,
        };
        let simulated = SimulatedProbe::new(spec, seed).map_err(|error| error.to_string())?;
        let shape = simulated.shape();
        Ok(Self {
            tool_from_image: simulated.image_on_tool().ok_or("the probe has no image")?,
            size_px: [shape.columns(), shape.rows()],
            face_mm: shape.along(0.5, 0.0).0,
            simulated,
        })
    }

    /// Where its beams run, as the scanner's own description has it: `--array`.
    fn array(&self) -> String {
        let [x, y] = self.face_mm.map(|mm| mm / PIXEL_MM);
        let radius = RADIUS_MM / PIXEL_MM;
        format!(
            "curved:{x},{},{radius},{}",
            y - radius,
            2.0 * HALF_ANGLE_RAD.to_degrees()
        )
    }
}

impl Work<'_> {
    /// The patient is registered by images of his bone: `registration.json`.
    pub(crate) fn registered_by_surface(
        &self,
        surface: &Surface,
        ct_from_reference: Rigid<Ct, Reference>,
        examined: &Examined,
        targets: &[Landmark],
    ) -> Result<(), Refused> {
        let mut room = TrueRoom::new(self.stratum, PROBE, mix(self.seed ^ mix(ROOM)));
        let room = room.as_mut().map_err(|why| Refused::at(Step::Probe)(why))?;
        let mut prepared = self.marker(room, (PROBE, Step::Probe))?;
        let speed = 1.0 + surface.speed * Chance::new(self.seed, SPEED).normal(0);
        let mut probe = TrueProbe::new(speed, self.seed).map_err(Refused::at(Step::Probe))?;
        self.probe(surface, (room, &mut prepared), &probe)?;
        self.swept(surface, (room, &mut prepared), &mut probe)?;
        self.guessed(surface, ct_from_reference, &examined.beads.ct_hash)?;
        let found = self.fitted(surface, examined, targets);
        found.map_err(|refused| self.with_registration(refused, ct_from_reference))
    }

    /// Wires are seen in a phantom: `probe.json`.
    fn probe(
        &self,
        surface: &Surface,
        (room, prepared): (&mut TrueRoom, &mut Prepared),
        probe: &TrueProbe,
    ) -> Result<(), Refused> {
        let failed = Refused::at(Step::Probe);
        let wires = Wires::new(surface, room.ct_from_reference(), Chance::new(self.seed, WIRES));
        let views = wires.views(surface.wire_images, (probe.tool_from_image, probe.face_mm));
        let tracked = Tracked::of(room, prepared, &views);
        tracked
            .write(&self.file("wires.mha"), probe.size_px, &[])
            .map_err(&failed)?;
        let points = wires.points(&views, probe.tool_from_image, PIXEL_MM);
        fs::write(self.file("wires.csv"), points).map_err(&failed)?;
        fs::write(self.file("wires.xml"), wires.config()).map_err(&failed)?;
        let [points, sequence, config, out] =
            ["wires.csv", "wires.mha", "wires.xml", "probe.json"].map(|name| self.named(name));
        let ([mm, deg], [pose_mm, pose_deg]) = (surface.phantom, tracked.noise());
        let numbers = [mm, deg, pose_mm, pose_deg, DEPTH_MM].map(|number| number.to_string());
        let [mm, deg, pose_mm, pose_deg, depth] = &numbers;
        let array = probe.array();
        let files = [
            "probe",
            "--points",
            &points,
            "--sequence",
            &sequence,
            "--config",
            &config,
        ];
        let errors = ["--phantom-error-mm", mm, "--phantom-error-deg", deg];
        let poses = ["--pose-noise-mm", pose_mm, "--pose-noise-deg", pose_deg];
        let images = [
            "--array",
            &array,
            "--depth-mm",
            depth,
            "--tool",
            PROBE.name,
            "--out",
            &out,
        ];
        self.calib(Step::Probe, &[&files[..], &errors, &poses, &images].concat())
            .map(drop)
    }

    /// The probe goes over the patient, and bone is found in its images: `seen.csv`.
    fn swept(
        &self,
        surface: &Surface,
        (room, prepared): (&mut TrueRoom, &mut Prepared),
        probe: &mut TrueProbe,
    ) -> Result<(), Refused> {
        let failed = Refused::at(Step::Sweep);
        let patient = patient();
        let mut way: Vec<_> = places(&patient, mix(self.seed ^ mix(HAND)))
            .into_iter()
            .step_by(surface.every)
            .collect();
        way.truncate((surface.share * way.len() as f64).ceil() as usize);
        let tracked = Tracked::of(room, prepared, &way);
        let tissue = |[x, y, z]: [f64; 3]| patient.hu(Point::new(x, y, z));
        let images: Result<Vec<Vec<u8>>, _> = (0..)
            .zip(&way)
            .map(|(number, place)| probe.simulated.image(&tissue, *place, number))
            .collect();
        let images = images.map_err(Refused::at(Step::Sweep))?;
        tracked
            .write(&self.file("sweep.mha"), probe.size_px, &images)
            .map_err(&failed)?;
        let [sequence, calibration, out] = ["sweep.mha", "probe.json", "seen.csv"].map(|name| self.named(name));
        let [mm, deg] = tracked.noise().map(|number| number.to_string());
        let words = [
            "bone-line",
            "--sequence",
            &sequence,
            "--probe",
            &calibration,
            "--pose-noise-mm",
            &mm,
            "--pose-noise-deg",
            &deg,
            "--to",
            &out,
        ];
        self.calib(Step::Sweep, &words).map(drop)
    }

    /// Landmarks that are known roughly: `guess.json`.
    fn guessed(
        &self,
        surface: &Surface,
        ct_from_reference: Rigid<Ct, Reference>,
        ct_hash: &str,
    ) -> Result<(), Refused> {
        let (patient, chance) = (patient(), Chance::new(self.seed, LANDMARKS));
        let mut text = "from_x,from_y,from_z,to_x,to_y,to_z\n".to_owned();
        let known = GUESSED.into_iter().filter_map(|number| patient.beads().get(number));
        for (number, landmark) in (0_u64..).zip(known) {
            let off = [0, 1, 2].map(|k| surface.guess_mm * chance.normal(3 * number + k));
            let seen = (ct_from_reference.inverse() * landmark.centre).mm();
            let seen = [0, 1, 2].map(|k| seen[k] + off[k]);
            text += &format!(
                "{},{}\n",
                listed(Point::<Reference>::new(seen[0], seen[1], seen[2])),
                listed(landmark.centre)
            );
        }
        fs::write(self.file("landmarks.csv"), text).map_err(Refused::at(Step::Surface))?;
        let [pairs, out] = ["landmarks.csv", "guess.json"].map(|name| self.named(name));
        let words = [
            "register",
            "--pairs",
            &pairs,
            "--to",
            "ct",
            "--from",
            "reference",
            "--ct-hash",
            ct_hash,
            "--out",
            &out,
        ];
        self.calib(Step::Surface, &words).map(drop)
    }

    fn fitted(&self, surface: &Surface, examined: &Examined, targets: &[Landmark]) -> Result<(), Refused> {
        let bone = examined.bone.as_ref().map(|path| path.to_string_lossy().into_owned());
        let bone = bone.ok_or_else(|| Refused::at(Step::Surface)("the examination has no bone"))?;
        let [points, probe, guess, out, refused] = [
            "seen.csv",
            "probe.json",
            "guess.json",
            "registration.json",
            "refused.json",
        ]
        .map(|name| self.named(name));
        let guess_mm = (GUESS_TIMES * surface.guess_mm).max(LEAST_GUESS_MM).to_string();
        let targets: Vec<String> = targets
            .iter()
            .map(|target| format!("--target={}", listed(target.centre)))
            .collect();
        let mut words = vec![
            "surface",
            "--bone",
            &bone,
            "--points",
            &points,
            "--probe",
            &probe,
            "--guess",
            &guess,
            "--guess-deg",
            GUESS_DEG,
            "--guess-mm",
            &guess_mm,
            "--out",
            &out,
            "--keep-refused",
            &refused,
        ];
        words.extend(targets.iter().map(String::as_str));
        self.calib(Step::Surface, &words).map(drop)
    }

    /// The refusal with the registration that was refused, where one was found, to be held against the truth.
    fn with_registration(&self, refused: Refused, truly: Rigid<Ct, Reference>) -> Refused {
        let text = fs::read_to_string(self.file("refused.json")).unwrap_or_default();
        let file = RegistrationFile::parse(&text.replacen(REFUSED_FORMAT, "trocar-registration", 1));
        let registration = match file.map(|file| file.registered) {
            Ok(Registered::Referenced(found)) => Some(Box::new(Misplaced { found, truly })),
            _ => None,
        };
        Refused {
            registration,
            ..refused
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::steps::true_from_calibrated;

    /// The image of the probe by the wires against the one that the simulator has, at the corners of where wires were seen: a mistake in a frame
    /// of the phantom, of the views or of the marker is centimetres.
    #[test]
    fn the_probe_is_calibrated_to_where_its_image_is() {
        let text = "[[stratum]]\nname = \"a\"\nregistration = \"surface\"";
        let plan = Plan::of_texts([(std::path::Path::new("a.toml"), text)]).unwrap();
        let (stratum, folder) = (&plan.strata[0], tempfile::tempdir().unwrap());
        let work = Work {
            stratum,
            seed: 7,
            folder: folder.path(),
        };
        let mut room = TrueRoom::new(stratum, PROBE, 8).unwrap();
        let mut prepared = work.marker(&mut room, (PROBE, Step::Probe)).unwrap();
        let probe = TrueProbe::new(1.0, 9).unwrap();
        let surface = stratum.dials.surface.unwrap();
        work.probe(&surface, (&mut room, &mut prepared), &probe).unwrap();
        let text = fs::read_to_string(work.file("probe.json")).unwrap();
        let file: calib_cli::ProbeFile = serde_json::from_str(&text).unwrap();
        let found = file.probe_from_image().unwrap();
        let gauge = true_from_calibrated(&room.emitters(), &prepared.emitters).unwrap();
        let truly = gauge.inverse() * room.room.marker_from_tool * probe.tool_from_image;
        let off = |[u, v]: [f64; 2]| {
            let seen = found.transform() * Point::<Image>::new(u * file.pixel_mm[0], v * file.pixel_mm[1], 0.0);
            let [x, y, z] = seen.mm();
            (truly * Point::<Image>::new(u * PIXEL_MM, v * PIXEL_MM, 0.0)).distance(Point::new(x, y, z))
        };
        // The file tells the root mean square at the worst of these corners: 3.2 times it is beyond one of a million.
        for place in [[170.0, 100.0], [370.0, 100.0], [170.0, 260.0], [370.0, 260.0]] {
            let mm = off(place);
            assert!(
                mm < 3.2 * file.error_mm && file.error_mm < 1.0,
                "{place:?}: {mm} {}",
                file.error_mm
            );
        }
    }
}
