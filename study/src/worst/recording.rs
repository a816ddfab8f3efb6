//! An approach as a recording: the topics, the attached scene and the facts that the recorder of a run would have left.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use bus::clock;
use bus::message::{Chosen, Guide, ToolPose, Tracked, VolumeHash};
use phantom::Landmark;
use recorder::wire::proto;
use recorder::wire::schema::{RunFacts, Source};
use recorder::write::pose_log::{Entry, PoseLog};
use scene::{Compression, Scene};
use tracker_proc::chain::{Chain, Found, Registration};

use crate::Words;
use crate::approach::Shot;
use crate::operation::Again;
use crate::plan::{Dials, Stratum};
use crate::room::{TUBE, tracker_text};
use crate::truth::understated;

/// The recording's name.
pub(super) const FILE: &str = "session.mcap";
const SCENE: &str = "scene.toml";
/// What is attached: what poses are made again with.
const ATTACHED: [&str; 2] = ["tool.json", "registration.json"];
/// From the beginning of the run to the first frame, s.
const BEFORE_S: f64 = 0.1;
/// A chunk is closed after this time, s.
const CHUNK_S: f64 = 0.5;
/// Beyond the localizer's latency an image is old, ms: as in a scene that says nothing of it.
const STALE_MS: f64 = 100.0;

/// Writes the recording and its scene to `folder`, which has the files of the operation; the examination lies at `ct` from there.
///
/// # Errors
/// In words.
pub(super) fn write(
    folder: &Path,
    (stratum, ct): (&Stratum, &Path),
    again: &Again,
    (targets, at): (&[Landmark], usize),
) -> Result<(), Words> {
    let text = scene_text((&stratum.dials, ct), again, targets);
    let scene = Scene::parse(&text, &folder.join(SCENE)).map_err(|error| error.to_string())?;
    fs::write(folder.join(SCENE), &text)?;
    let first = again.tape.shots.first().ok_or("nothing was seen of it")?;
    let times = Times {
        origin_ns: first.frame.t_capture_ns - clock::seconds(BEFORE_S),
        latency_ns: clock::seconds(stratum.dials.localizer.latency_s),
    };
    let id = registration_id(&again.chain);
    let facts = RunFacts {
        name: format!("{}-{}", stratum.name, again.row.number),
        epoch_ns: 0,
        registration_id: Some(id),
        volume_hash: Some(hash(&again.ct_hash)?),
        remade_from: None,
    };
    let mut log = PoseLog::new(
        BufWriter::new(File::create_new(folder.join(FILE))?),
        Compression::Zstd,
        &[],
    )?;
    // No time of day: the same study gives the same bytes.
    log.scene(&text, 0)?;
    for name in ATTACHED {
        log.attach(name, "application/json", &fs::read(folder.join(name))?, 0)?;
    }
    log.facts(&facts)?;
    let target = scene.targets.get(at).ok_or("the scene has no such target")?;
    let guide = proto::Guide::from(&guide(target));
    log.put(Entry::Guide(0, &guide))?;
    let mut chunk = 0;
    for shot in &again.tape.shots {
        put(&mut log, shot, &times, (id, stratum.dials.understated))?;
        // Chunks by time, and no clock of the machine.
        let now = (clock::ms(shot.frame.t_capture_ns - times.origin_ns) / 1e3 / CHUNK_S) as i64;
        if now > chunk {
            chunk = now;
            log.flush()?;
        }
    }
    log.finish()?;
    Ok(())
}

/// How script time becomes the time of the recorded run.
struct Times {
    origin_ns: i64,
    latency_ns: i64,
}

fn put(
    log: &mut PoseLog<BufWriter<File>>,
    shot: &Shot,
    times: &Times,
    (id, times_smaller): (u64, f64),
) -> Result<(), Words> {
    let frame = &shot.frame;
    let t_capture_ns = frame.t_capture_ns - times.origin_ns;
    let t_publish_ns = t_capture_ns + times.latency_ns;
    let emitters = frame.message(t_capture_ns, t_publish_ns);
    let emitters = proto::EmitterFrame::try_from(&emitters).map_err(|error| error.to_string())?;
    log.put(Entry::Emitters(&emitters))?;
    let empty = ToolPose {
        seq: frame.seq,
        t_device_ns: frame.t_device_ns,
        t_capture_ns,
        t_publish_ns,
        registration_id: id,
        // At most 32 emitters.
        visible: frame.tool.len() as u32,
        ..ToolPose::EMPTY
    };
    let mut pose = empty;
    match &shot.found {
        Ok(found) => shown(&mut pose, found, times_smaller),
        Err(reason) => pose.set(Tracked::Lost(reason.lost())),
    }
    log.put(Entry::Pose(Source::Tool, &pose))?;
    let mut truth = empty;
    truth.set(Tracked::Valid(frame.ct_from_tool));
    Ok(log.put(Entry::Pose(Source::Truth, &truth))?)
}

/// The pose as the operator was shown it.
fn shown(pose: &mut ToolPose, found: &Found, times_smaller: f64) {
    pose.set(Tracked::Valid(found.ct_from_tool.transform()));
    pose.covariance = understated(&found.ct_from_tool, times_smaller);
    pose.tip_mm = found.tip_95_mm / times_smaller;
    pose.fre_rms_mm = found.fre_rms_mm;
    pose.used = found.used as u32;
    pose.flags |= ToolPose::TIP_KNOWN;
}

/// What poses rest on, as the tracker names it.
fn registration_id(chain: &Chain) -> u64 {
    let (q, t) = match &chain.registration {
        Registration::Fixed(at) => (at.transform().quaternion(), at.transform().translation_mm()),
        Registration::Referenced(at) => (at.transform().quaternion(), at.transform().translation_mm()),
    };
    let tool = chain.marker_from_tool.transform();
    scene::registration_id(&[&q[..], &t, &tool.quaternion(), &tool.translation_mm()].concat())
}

/// The target that is approached is chosen from the beginning on.
fn guide(target: &scene::Target) -> Guide {
    let chosen = Chosen {
        name: target.name.clone(),
        centre: target.centre,
        radius_mm: 0.5 * target.diameter_mm,
        entry: None,
        stop_mm: 0.0,
    };
    Guide::default().choosing(Some(&chosen), scene::plan_id(target))
}

/// The tracker's scene of the operation, with the examination and the targets.
fn scene_text((dials, ct): (&Dials, &Path), again: &Again, targets: &[Landmark]) -> String {
    let mut text = format!(
        "{}[volume]\nsource = {:?}\n",
        tracker_text(dials, TUBE, &again.emitters),
        ct.display().to_string()
    );
    text += "[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n[tracker.registration]\nfile = \"registration.json\"\n";
    text += &format!(
        "[limits]\nstale_ms = {:?}\n",
        STALE_MS + 1e3 * dials.localizer.latency_s
    );
    for target in targets {
        let [x, y, z] = target.centre.mm();
        text += &format!(
            "[[targets]]\nname = {:?}\nct_mm = [{x:?}, {y:?}, {z:?}]\ndiameter_mm = {:?}\n",
            target.name,
            2.0 * dials.radius_mm
        );
    }
    text
}

/// The examination's hash of its digits.
fn hash(digits: &str) -> Result<VolumeHash, Words> {
    let mut bytes = [0; 32];
    if digits.len() != 64 || !digits.is_ascii() {
        return Err(format!("{digits:?} is no hash of an examination").into());
    }
    for (at, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(&digits[2 * at..2 * at + 2], 16)?;
    }
    Ok(VolumeHash(bytes))
}
