//! What a person chose and how far a run has come, with real processes.

use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::support::{Pilot, SMALL, World, kill_9, png_texts, stderr, stdout, wait_for};
use bus::Bus;
use bus::message::{Ages, Command, CommandKind, Guide, Lost, ToolPose, Tracked, Workflow};
use bus::port::{CommandClient, FrameSubscriber, Reply, Subscriber, VolumeSubscriber};
use bus::run::RunContext;
use bus::topic::{GUIDE, HELD_FRAME, TOOL_POSE, VIEW_FRAME, WORKFLOW};
use geometry::{Point, Tool};
use recorder::read::{reader, scan};
use recorder::wire::schema::{LOG, TOOL_POSE as TOOL_POSES};

const PATIENCE: Duration = Duration::from_secs(60);
const VIEW: &str = "perpendicular";

/// The small scene with a choice, and one view large enough for words.
fn scene(choice: &str) -> String {
    let at = SMALL.rfind("[128, 128]").unwrap();
    let (before, last) = SMALL.split_at(at);
    let scene = format!("{before}{}", last.replace("[128, 128]", "[256, 256]"));
    scene.replace("[recording]", &format!("[guide]\ntarget = \"{choice}\"\n[recording]"))
}

fn join(world: &World, run: &str) -> Bus {
    let context = wait_for("the run", || RunContext::load(&world.run_dir(run)).ok());
    Bus::join(&context).unwrap()
}

fn guides(bus: &Bus) -> Subscriber<Guide> {
    Subscriber::open(bus, &GUIDE, "", GUIDE.buffer).unwrap()
}

fn name(guide: &Guide) -> Option<String> {
    guide.chosen().unwrap().map(|chosen| chosen.name)
}

/// The newest guide with this target, as one that comes late hears it too.
fn wait_chosen(guides: &Subscriber<Guide>, target: Option<&str>) -> Guide {
    let mut last = None;
    wait_for(&format!("{target:?} to be chosen"), || {
        last = guides.newest().unwrap().or(last);
        last.filter(|guide| name(guide).as_deref() == target)
    })
}

fn pilot(world: &World, arguments: &[&str]) -> Result<String, String> {
    let output = world.output("pilot", arguments);
    match output.status.success() {
        true => Ok(stdout(&output)),
        false => Err(stderr(&output)),
    }
}

/// The next valid pose.
fn pose(poses: &Subscriber<ToolPose>) -> ToolPose {
    wait_for("a pose", || poses.newest().unwrap().filter(|pose| pose.status == 0))
}

/// The pixels of `pose`, drawn because it was asked for.
fn held(bus: &Bus, frames: &FrameSubscriber, pose: ToolPose) -> Vec<u8> {
    // A renderer that was killed a moment ago has no server yet.
    wait_for("an image", || {
        let client = CommandClient::open(bus, &format!("view-{VIEW}")).ok()?;
        let reply = client.ask(Command::render(pose), PATIENCE).ok()?;
        assert!(!reply.refused, "{}", reply.text);
        let frame = frames.newest().unwrap()?;
        let stamp = frame.header().stamp;
        let ages = Ages {
            stale_ns: i64::MAX,
            lost_ns: i64::MAX,
        };
        (stamp.seq == pose.seq).then(|| frame.shown(stamp.t_framed_ns, ages).rgba.to_vec())
    })
}

fn kill_for_another(run: &Pilot<'_>, process: &str) {
    let victim = wait_for(process, || run.pid(process));
    kill_9(victim);
    wait_for(process, || run.pid(process).filter(|pid| *pid != victim));
    run.wait_live();
}

fn names(recording: &Path) -> Vec<Option<String>> {
    let guides = reader::guides(recording).unwrap();
    let mut names: Vec<_> = guides.map(|guide| name(&guide.unwrap())).collect();
    names.dedup();
    names
}

#[test]
fn a_choice_outlives_a_renderer_and_comes_back_in_a_replay() {
    let world = World::new();
    let run = world.start(
        &world.file("s.toml", &scene("pre-aortic")),
        &world.path("out"),
        "default",
    );
    let bus = join(&world, "default");
    let heard = guides(&bus);
    let first = wait_chosen(&heard, Some("pre-aortic"));
    assert_eq!(first.t_ns, 0);
    run.wait_live();

    let said = pilot(&world, &["choose", "nobody"]).unwrap_err();
    assert!(
        said.contains("\"nobody\"") && said.contains("para-caval-right"),
        "{said}"
    );
    pilot(&world, &["choose", "iliac-left"]).unwrap();
    let chosen = wait_chosen(&heard, Some("iliac-left"));
    assert!(chosen.t_ns > 0 && chosen.plan_id != first.plan_id);

    // An image shows what was chosen when its pose was captured.
    let poses = Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 1).unwrap();
    let frames = FrameSubscriber::open(&bus, &HELD_FRAME, VIEW).unwrap();
    let after = wait_for("a pose behind the choice", || {
        Some(pose(&poses)).filter(|p| p.t_capture_ns > chosen.t_ns)
    });
    let before = ToolPose {
        t_capture_ns: chosen.t_ns - 1,
        ..after
    };
    let pixels = held(&bus, &frames, after);
    assert!(pixels != held(&bus, &frames, before), "the choice is not on the image");
    kill_for_another(&run, "view-perpendicular");
    assert!(
        pixels == held(&bus, &frames, after),
        "the renderer came back with another choice"
    );
    let status = run.wait_live();
    assert_eq!(status["guiding"]["target"], "iliac-left");
    assert_eq!(wait_chosen(&guides(&bus), Some("iliac-left")), chosen);
    pilot(&world, &["choose", "--none"]).unwrap();
    wait_chosen(&heard, None);
    pilot(&world, &["choose", "para-caval-right"]).unwrap();
    wait_chosen(&heard, Some("para-caval-right"));
    // What is chosen now is nothing to a pose that was captured before.
    assert!(pixels == held(&bus, &frames, after));
    drop((heard, poses, frames, bus));
    assert_eq!(run.stop().code(), Some(3), "a process was killed");

    let recording = world.path("out").join("session.mcap");
    let told =
        ["pre-aortic", "iliac-left", "", "para-caval-right"].map(|name| (!name.is_empty()).then(|| name.to_owned()));
    assert_eq!(names(&recording), told);
    replayed(&world, &recording, &told);
}

/// A replay of its end draws the pictures of the run, byte for byte.
fn same_pictures(world: &World, recording: &Path) {
    let path = recording.to_string_lossy();
    let live = world.path("out");
    let seq: u64 = png_texts(&live.join(format!("{VIEW}.png")))["pose_seq"]
        .parse()
        .unwrap();
    let poses: Vec<ToolPose> = reader::poses(recording, TOOL_POSES)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let last = poses.iter().find(|pose| pose.seq == seq).unwrap();
    // What was chosen before the part that is replayed holds in it.
    let at_s = bus::clock::ms(last.t_publish_ns - poses[0].t_publish_ns) / 1e3;
    let (from, to) = (format!("{:.3}s", (at_s - 0.2).max(0.0)), format!("{:.3}s", at_s + 0.1));
    let out = world.path("again");
    let part = [
        "replay",
        &path,
        "--from",
        &from,
        "--to",
        &to,
        "--out",
        &out.to_string_lossy(),
    ];
    pilot(
        world,
        &[&part[..], &["--headless", "--speed", "max", "--images", "every"]].concat(),
    )
    .unwrap();
    for view in ["axial-global", "frontal-local", VIEW] {
        let [then, now] = [
            live.join(format!("{view}.png")),
            out.join(format!("images/{view}-{seq:06}.png")),
        ];
        assert!(fs::read(then).unwrap() == fs::read(now).unwrap(), "{view}, pose {seq}");
    }
}

/// Its replay tells the same, and draws the same pictures.
fn replayed(world: &World, recording: &Path, told: &[Option<String>]) {
    same_pictures(world, recording);
    let path = recording.to_string_lossy();
    let child = world
        .command("pilot")
        .args([
            "replay",
            &*path,
            "--headless",
            "--loop",
            "--speed",
            "max",
            "--run",
            "loop",
            "--out",
        ])
        .arg(world.path("loop"))
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let looping = Pilot::of(world, "loop", child);
    let bus = join(world, "loop");
    let heard = guides(&bus);
    // Around once, wherever it began.
    for target in told.iter().chain(told) {
        wait_next(&heard, target.as_deref());
    }
    for arguments in [
        &["choose", "iliac-left"][..],
        &["hold"],
        &["follow"],
        &["mark", "x"],
        &["images", "--field", "60"],
    ] {
        let said = pilot(world, &[arguments, &["--run", "loop"]].concat()).unwrap_err();
        assert!(said.contains("replay"), "{said}");
    }
    assert!(looping.stop().success());
}

/// As numbers of HU and mm, of the newest image of a view.
fn look(frames: &FrameSubscriber) -> Option<[f64; 3]> {
    let plane = frames.newest().unwrap()?.header().plane;
    let field = plane.pixel_mm * 128.0;
    Some([plane.centre_hu, plane.width_hu, (field * 1e6).round() / 1e6])
}

/// Every image of a pose has the window and the field that held when it was captured, whichever process drew it, and a replay has them
/// again.
#[test]
fn window_and_field_change_in_all_views_and_come_back_in_a_replay() {
    let world = World::new();
    let run = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    let bus = join(&world, "default");
    run.wait_live();
    for (bad, what) in [
        (&["--field", "0.5"][..], "field is 0.5"),
        (&["--field", "2001"], "1 to 2000 mm"),
        (&["--window", "40,0.5"], "width is 0.5"),
        (&["--window", "-40000,400"], "centre is -40000"),
        (&["--field", "NaN"], "field is NaN"),
    ] {
        let said = pilot(&world, &[&["images"], bad].concat()).unwrap_err();
        assert!(said.contains(what), "{said}");
    }
    assert_eq!(run.wait_live()["guiding"]["images"], "");
    let frames =
        ["axial-global", "frontal-local", VIEW].map(|view| FrameSubscriber::open(&bus, &VIEW_FRAME, view).unwrap());
    let said = pilot(&world, &["images", "--window", "bone", "--field", "60"]).unwrap();
    assert!(said.contains("W 2000 C 400, field 60 mm"), "{said}");
    for frames in &frames[1..] {
        wait_for("the images to change", || {
            look(frames).filter(|look| *look == [400.0, 2000.0, 60.0])
        });
    }
    // What shows the whole examination has a window and no field.
    let whole = wait_for("the images to change", || {
        look(&frames[0]).filter(|look| look[..2] == [400.0, 2000.0])
    });
    assert!(whole[2] > 200.0, "{whole:?}");
    // Killed, a renderer comes back with what holds.
    kill_for_another(&run, "view-perpendicular");
    let frames = FrameSubscriber::open(&bus, &VIEW_FRAME, VIEW).unwrap();
    wait_for("the image to come back", || {
        look(&frames).filter(|look| *look == [400.0, 2000.0, 60.0])
    });
    assert_eq!(run.wait_live()["guiding"]["images"], "W 2000 C 400, field 60 mm");
    pilot(&world, &["images", "--scene", "--window", "-600,1500"]).unwrap();
    wait_for("the images to change", || {
        look(&frames).filter(|look| *look == [-600.0, 1500.0, 100.0])
    });
    drop((frames, bus));
    assert_eq!(run.stop().code(), Some(3), "a process was killed");
    let recording = world.path("out").join("session.mcap");
    let told: Vec<_> = reader::guides(&recording)
        .unwrap()
        .map(|guide| guide.unwrap().images().unwrap().words())
        .collect();
    let mut told: Vec<&str> = told.iter().map(String::as_str).collect();
    told.dedup();
    assert_eq!(told, ["", "W 2000 C 400, field 60 mm", "W 1500 C -600"]);
    same_pictures(&world, &recording);
}

/// The next guide with this target; others are passed over.
fn wait_next(guides: &Subscriber<Guide>, target: Option<&str>) {
    wait_for(&format!("{target:?} to be told"), || {
        while let Some(guide) = guides.next().unwrap() {
            if name(&guide).as_deref() == target {
                return Some(());
            }
        }
        None
    });
}

#[test]
fn the_nearest_target_never_takes_the_place_of_the_chosen_one() {
    let world = World::new();
    // The tube goes to another: para-aortic-left.
    let run = world.start(
        &world.file("s.toml", &scene("iliac-right")),
        &world.path("out"),
        "default",
    );
    let bus = join(&world, "default");
    let heard = guides(&bus);
    let chosen = wait_chosen(&heard, Some("iliac-right")).chosen().unwrap().unwrap();
    let patient = phantom::Phantom::new(1);
    let near = patient.targets().iter().find(|t| t.name == "para-aortic-left").unwrap();
    let poses = Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 4096).unwrap();
    let mut nearer = 0;
    wait_for("a hundred poses that are nearer to another target", || {
        while let Some(pose) = poses.next().unwrap() {
            if let Ok(Tracked::Valid(at)) = pose.tracked() {
                let tip = at * Point::<Tool>::new(0.0, 0.0, 0.0);
                nearer += u32::from(near.centre.distance(tip) < 10.0 && chosen.centre.distance(tip) > 30.0);
            }
        }
        (nearer > 100).then_some(())
    });
    assert!(heard.next().unwrap().is_none(), "somebody chose");
    assert_eq!(run.wait_live()["guiding"]["target"], "iliac-right");
    drop((heard, poses, bus));
    assert!(run.stop().success());
    assert_eq!(
        names(&world.path("out").join("session.mcap")),
        [Some("iliac-right".to_owned())]
    );
}

fn ask(bus: &Bus, command: Command) -> Reply {
    let client = CommandClient::open(bus, "pilot").unwrap();
    client.ask(command, PATIENCE).unwrap()
}

#[test]
fn poses_are_held_and_moments_noted() {
    let world = World::new();
    let run = world.start(
        &world.file("s.toml", &scene("pre-aortic")),
        &world.path("out"),
        "default",
    );
    let bus = join(&world, "default");
    let heard = guides(&bus);
    run.wait_live();
    pilot(&world, &["hold"]).unwrap();
    let held = wait_for("a held pose", || {
        heard.newest().unwrap().filter(|guide| guide.held().is_some())
    });
    assert_eq!(name(&held).as_deref(), Some("pre-aortic"));
    assert_eq!(run.wait_live()["guiding"]["held_seq"], held.held_seq);
    pilot(&world, &["follow"]).unwrap();
    let follows = wait_for("none held", || {
        heard.newest().unwrap().filter(|guide| guide.held().is_none())
    });
    assert_eq!(name(&follows).as_deref(), Some("pre-aortic"));
    let mut lost = ToolPose::EMPTY;
    lost.set(Tracked::Lost(Lost::NotSeen));
    let reply = ask(&bus, Command::hold(lost));
    assert!(
        reply.refused && reply.text.contains("marker not seen"),
        "{}",
        reply.text
    );
    pilot(&world, &["mark", "first", "incision, é"]).unwrap();
    assert!(
        pilot(&world, &["mark", &"é".repeat(49)])
            .unwrap_err()
            .contains("98 bytes")
    );
    drop((heard, bus));
    assert!(run.stop().success());
    let items = scan::open(&world.path("out").join("session.mcap")).unwrap();
    let lines = items.filter_map(|item| match item.unwrap() {
        scan::Item::Message(message) if message.channel.topic == LOG => {
            Some(String::from_utf8_lossy(&message.data).into_owned())
        }
        _ => None,
    });
    let log: Vec<String> = lines.collect();
    for words in [
        "mark: first incision, é",
        &format!("held: pose {}", held.held_seq),
        "the tool is followed again",
    ] {
        assert!(log.iter().any(|line| line.contains(words)), "{words}");
    }
}

/// The newest that was said of the workflow.
fn stage(workflows: &Subscriber<Workflow>, is_it: impl Fn(&Workflow) -> bool) -> Workflow {
    let mut last = None;
    wait_for("the workflow", || {
        last = workflows.newest().unwrap().or(last);
        last.filter(&is_it)
    })
}

fn is_at(told: &Workflow, stage: &str) -> bool {
    told.stage().is_some_and(|found| found.word() == stage)
}

#[test]
fn a_strict_run_waits_for_a_person_and_a_research_run_does_not() {
    let world = World::new();
    let strict = scene("pre-aortic").replace("[recording]", "[workflow]\nstrict = true\n[recording]");
    let run = world.start(&world.file("strict.toml", &strict), &world.path("strict"), "default");
    let bus = join(&world, "default");
    let workflows = Subscriber::<Workflow>::open(&bus, &WORKFLOW, "", WORKFLOW.buffer).unwrap();
    let status = run.wait_live();
    assert_eq!(
        (&status["guiding"]["stage"], &status["guiding"]["research"]),
        (&"LOADED".into(), &false.into())
    );
    let hash = volume_hash(&bus);
    let first = if hash.starts_with('0') { "1" } else { "0" };
    let other = format!("{first}{}", &hash[1..]);
    let wrong = ask(&bus, Command::with_text(CommandKind::Confirm, &other));
    assert!(wrong.refused && wrong.text.contains(&hash), "{}", wrong.text);
    let start = ask(&bus, Command::new(CommandKind::Navigate));
    assert!(
        start.refused && start.text.contains("nobody has confirmed"),
        "{}",
        start.text
    );
    assert!(!ask(&bus, Command::with_text(CommandKind::Confirm, &hash)).refused);
    let registered = stage(&workflows, |told| is_at(told, "REGISTERED"));
    assert!(registered.has(Workflow::CONFIRMED | Workflow::NOT_CHECKED) && !registered.has(Workflow::RESEARCH));
    // Nobody has touched a point.
    assert!(ask(&bus, Command::new(CommandKind::Navigate)).refused);
    assert!(!ask(&bus, Command::new(CommandKind::Reject)).refused);
    stage(&workflows, |told| is_at(told, "LOADED") && told.has(Workflow::REJECTED));
    drop((workflows, bus));
    assert!(run.stop().success());

    let run = world.start(
        &world.file("s.toml", &scene("pre-aortic")),
        &world.path("out"),
        "default",
    );
    let status = run.wait_for("the navigation", |status| status["guiding"]["stage"] == "NAVIGATING");
    assert_eq!(status["guiding"]["research"], true);
    let bus = join(&world, "default");
    let workflows = Subscriber::<Workflow>::open(&bus, &WORKFLOW, "", WORKFLOW.buffer).unwrap();
    stage(&workflows, |told| told.has(Workflow::RESEARCH | Workflow::SIGHT));
    assert!(!ask(&bus, Command::new(CommandKind::Rest)).refused);
    stage(&workflows, |told| is_at(told, "REGISTERED"));
    assert!(!ask(&bus, Command::new(CommandKind::Navigate)).refused);
    stage(&workflows, |told| is_at(told, "NAVIGATING"));
    drop((workflows, bus));
    assert!(run.stop().success());
}

/// The hash of the examination as a person's screen has it.
fn volume_hash(bus: &Bus) -> String {
    let volumes = VolumeSubscriber::open(bus).unwrap();
    wait_for("the volume", || {
        volumes.poll().unwrap().map(|volume| volume.hash().to_string())
    })
}
