//! The end of a run: every view shows one and the same pose, the pictures are written, the report is built from the metrics.

mod sheet;

use std::collections::BTreeMap;
use std::fs;

use bus::clock;
use bus::message::{Ages, Command, CommandKind, FrameStamp, ToolPose};
use bus::port::FrameSubscriber;
use bus::session::SIMULATED_START_NS;
use picture::{Canvas, Rgb, palette, write_png};
use scene::Scene;

use crate::child::Child;
use crate::metrics::memory;
use crate::output;
use crate::problems::{missing, problems};
use crate::remote::RemoteReport;
use crate::replay::Recomputed;
use crate::report::{MemoryReport, Pictures, ProcessReport, Report, ViewReport, VolumeReport};
use crate::spawn;
use crate::state::{Options, Run};
use sheet::Panel;

const SHEET: &str = "sheet.png";

/// The files that [`take_pictures`] writes for a scene.
pub(crate) fn picture_names(scene: &Scene) -> Vec<String> {
    let views = scene.views.iter().map(|view| format!("{}.png", view.name));
    views.chain([SHEET.to_owned()]).collect()
}

/// Asks every renderer for an image of the run's last valid pose, writes the pictures and the sheet, and takes the processes'
/// notes and memory while all are alive. A renderer may take as long as it may be silent.
pub(crate) fn take_pictures(run: &Run) -> Pictures {
    // Nobody else asks for images meanwhile, and no further pose comes.
    if let Some(replayer) = &run.ports.replayer {
        let _ = replayer.ask(Command::new(CommandKind::Pause), run.scene.limits.silent);
    }
    let mut pictures = Pictures {
        at_ns: match run.options.simulated_time {
            true => run.session.clock().now_ns(),
            false => run.bus.clock().now_ns(),
        },
        pngs: vec![None; run.scene.views.len()],
        ..Pictures::default()
    };
    let pose = run.metrics.valid_pose_until(run.last_seq());
    let mut panels: Vec<Panel> = run.scene.views.iter().map(|_| Panel { image: None }).collect();
    match &pose {
        Some(pose) => render_views(run, pose, &mut panels, &mut pictures.problems),
        None => pictures
            .problems
            .push("no valid pose was published: there is no picture to show".to_owned()),
    }
    for (view, panel) in panels.iter().enumerate() {
        pictures.pngs[view] = write_view(run, view, panel, &mut pictures.problems);
    }
    let sheet = sheet::draw(&run.scene, &panels, pose.as_ref(), sheet_caption(run, pose.as_ref()));
    let stamp = panels
        .iter()
        .find_map(|p| p.image.as_ref())
        .map(|(_, stamp)| stamp.texts());
    if let Err(error) = write_png(&run.options.out.join(SHEET), &sheet, &stamp.unwrap_or_default()) {
        pictures.problems.push(error.to_string());
    }
    pictures.processes = process_reports(run);
    pictures.memory = measure_memory(run);
    pictures
}

/// What the sheet must say beside its pictures: of a replay that shows something else than was recorded, or that the pose was
/// old when the run ended.
fn sheet_caption(run: &Run, pose: Option<&ToolPose>) -> Option<(String, Rgb)> {
    if let Some(replay) = &run.options.replay {
        let shown = run.metrics.volume_hash().map(|hash| hash.to_string());
        return Some((replay.title(shown.as_deref())?, palette::REPLAY));
    }
    let age_ns = run.session.clock().now_ns().saturating_sub(pose?.t_capture_ns);
    let is_old = age_ns > Ages::of(&run.scene.limits).lost_ns;
    is_old.then(|| {
        (
            format!("the pose was {:.1} s OLD", clock::ms(age_ns) / 1e3),
            palette::WARN,
        )
    })
}

/// Has `pose` drawn by every renderer that is ready, and takes the images of its views. An image of another volume than was
/// loaded is not taken; what is missing becomes a problem.
fn render_views(run: &Run, pose: &ToolPose, panels: &mut [Panel], problems: &mut Vec<String>) {
    for (process, client) in &run.ports.renderers {
        let planned = &run.children[*process].planned;
        if !run.supervisor.is_ready(*process) {
            problems.push(format!("{} is not running: its views are not shown", planned.name));
            continue;
        }
        match client.ask(Command::render(*pose), run.scene.limits.silent) {
            Ok(reply) if !reply.refused => {}
            Ok(reply) => {
                problems.push(format!(
                    "{} refused to draw pose {}: {}",
                    planned.name, pose.seq, reply.text
                ));
                continue;
            }
            Err(error) => {
                problems.push(format!("{}: {error}", planned.name));
                continue;
            }
        }
        for &view in &planned.views {
            panels[view].image = requested_frame(&run.ports.held[view], pose.seq, Ages::of(&run.scene.limits));
            let name = &run.scene.views[view].name;
            match &panels[view].image {
                None => problems.push(format!(
                    "{name}: its renderer took the request for pose {} but handed no image of it over",
                    pose.seq
                )),
                Some((_, stamp)) if Some(stamp.volume()) != run.metrics.volume_hash() => {
                    panels[view].image = None;
                    problems.push(format!("{name} shows another volume than was loaded"));
                }
                Some(_) => {}
            }
        }
    }
}

/// The newest image of a view, where it is of the pose `seq` and was drawn because it was asked for.
fn requested_frame(frames: &FrameSubscriber, seq: u64, ages: Ages) -> Option<(Canvas, FrameStamp)> {
    let frame = frames.newest().ok()??;
    let header = *frame.header();
    if header.stamp.seq != seq || header.stamp.on_request != 1 {
        return None;
    }
    let mut canvas = Canvas::new(header.width, header.height);
    // Asked for: it claims nothing of the present, whatever the time is.
    canvas.paste(frame.shown(header.stamp.t_framed_ns, ages).rgba, header.width, 0, 0);
    Some((canvas, header.stamp))
}

/// Writes a view's picture; its name and the number of its pose.
fn write_view(run: &Run, view: usize, panel: &Panel, problems: &mut Vec<String>) -> Option<(String, u64)> {
    let (canvas, stamp) = panel.image.as_ref()?;
    let name = format!("{}.png", run.scene.views[view].name);
    let mut texts = stamp.texts();
    texts.push(("view", run.scene.views[view].name.clone()));
    match write_png(&run.options.out.join(&name), canvas, &texts) {
        Ok(()) => Some((name, stamp.seq)),
        Err(error) => {
            problems.push(error.to_string());
            None
        }
    }
}

/// Each process with what it said of itself last.
fn process_reports(run: &Run) -> Vec<ProcessReport> {
    let report = |child: &Child| ProcessReport {
        name: child.name().to_owned(),
        note: child.note.clone(),
    };
    run.children.iter().map(report).collect()
}

/// The memory of all processes, and how much of it is the volume, which they share.
fn measure_memory(run: &Run) -> MemoryReport {
    let Some(volume) = &run.metrics.volume else {
        return MemoryReport::default();
    };
    let mut report = MemoryReport {
        volume_bytes: volume.dims.iter().map(|&d| u64::from(d)).product::<u64>() * 2,
        ..MemoryReport::default()
    };
    let children = run.children.iter();
    let running = children.filter_map(|child| Some((child.running.as_ref()?.pid(), child.name().to_owned())));
    for (pid, name) in running.chain([(std::process::id(), "pilot".to_owned())]) {
        let memory = memory::of_process(pid, volume.shm_inode);
        report.volume_mapped_pss_bytes += memory.volume_pss;
        report.process_pss_bytes.insert(name, memory.pss);
    }
    report.volume_ratio = report.volume_mapped_pss_bytes as f64 / report.volume_bytes.max(1) as f64;
    report
}

/// Builds the report from the metrics and the pictures.
pub(crate) fn report(run: &Run) -> Report {
    let nothing = Pictures::default();
    let pictures = run.pictures.as_ref().unwrap_or(&nothing);
    let volume = run.metrics.volume.as_ref().map(|v| VolumeReport {
        hash: v.volume_hash().to_string(),
        dims: v.dims,
        ct_from_voxel: v.ct_from_voxel,
        brick: v.brick,
        padding_hu: v.padding_hu,
        marks: v.marks().words(),
    });
    // What the poses say: it may have come from files.
    let registration_id = run.metrics.registration_id;
    let registration_id = registration_id.unwrap_or_else(|| run.scene.registration_id());
    Report {
        trocar_version: env!("CARGO_PKG_VERSION"),
        run: run.options.run.clone(),
        scene: run.source.path.display().to_string(),
        seed: run.scene.seed,
        duration_s: duration_s(run, pictures),
        simulated_time: run.options.simulated_time,
        registration_id: format!("{registration_id:016x}"),
        volume,
        replay: run.replay_report(),
        remote: remote_report(run),
        poses: run.metrics.poses,
        accuracy: run.metrics.accuracy.report(),
        latency_ms: run.metrics.all_latencies().collect::<BTreeMap<_, _>>(),
        views: (0..run.scene.views.len())
            .map(|view| view_report(run, view, pictures))
            .collect(),
        tissue: run.metrics.tissue.report(&run.scene),
        check: run.guiding.check_report(),
        processes: pictures.processes.clone(),
        memory: pictures.memory.clone(),
        restarts: run.metrics.restarts.clone(),
        held: run.held().map(str::to_owned).collect(),
        recording: output::recordings(&run.options.out, run.options.recording()),
        problems: problems(run, pictures),
        notes: notes(run),
    }
}

fn remote_report(run: &Run) -> Option<RemoteReport> {
    let shown = run.metrics.volume_hash().map(|hash| hash.to_string());
    Some(run.options.remote.as_ref()?.report(shown.as_deref()))
}

/// Of a run that navigated, what is missing of its samples; of a replay, what nobody knows of its files.
fn notes(run: &Run) -> Vec<String> {
    match &run.options.replay {
        Some(replay) => replay.unknown_files.clone(),
        None => missing::note(&run.metrics.poses, &run.scene.limits)
            .into_iter()
            .collect(),
    }
}

/// From sample 0 to the taking of the pictures, s.
fn duration_s(run: &Run, pictures: &Pictures) -> f64 {
    let began_ns = match run.options.simulated_time {
        true => run.began_ns.map(|_| SIMULATED_START_NS),
        false => run.began_ns,
    };
    began_ns.map_or(0.0, |began_ns| clock::ms(pictures.at_ns - began_ns) / 1e3)
}

fn view_report(run: &Run, view: usize, pictures: &Pictures) -> ViewReport {
    let spec = &run.scene.views[view];
    let counts = &run.metrics.views[view];
    let png = pictures.pngs.get(view).and_then(Option::as_ref);
    let valid_poses = run.metrics.poses.published - run.metrics.poses.lost - run.metrics.poses.refused;
    ViewReport {
        name: spec.name.clone(),
        process: spec.plane.process(),
        size: spec.size,
        rendered: counts.rendered,
        dropped: valid_poses.saturating_sub(counts.rendered),
        unflagged_old: counts.unflagged_old,
        png: png.map(|(name, _)| name.clone()),
        seq: png.map(|(_, seq)| *seq),
    }
}

/// Has the report attached to the last file of the session, where that is whole. Why it could not be is on stderr.
pub(crate) fn attach_report(options: &Options) {
    let out = &options.out;
    let session = out.join(options.recording());
    if !session.exists() {
        return;
    }
    if let Err(error) = spawn::attach(&session, &out.join("report.json")) {
        bus::stderr_line!("pilot: the report is not in the recording: {error}");
    }
}

/// Removes the recordings of a run that never navigated: an empty one would look like a session.
pub(crate) fn remove_recordings(options: &Options) {
    for name in output::recordings(&options.out, options.recording()) {
        let _ = fs::remove_file(options.out.join(name));
    }
}

/// Compares poses that were recomputed with those of the recording, once both files are whole; `None` where none were.
pub(crate) fn compare_recomputed(options: &Options) -> Option<Recomputed> {
    let (replay, recompute) = options.recompute()?;
    Some(recompute.compare(&replay.recording, &options.out))
}
