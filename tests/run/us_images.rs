//! Images of the simulated ultrasound probe: on the bus, recorded, and replayed.

use std::collections::BTreeMap;

use crate::support::{SMALL, World, wait_for};
use bus::Bus;
use bus::message::UsImageHeader;
use bus::port::UsImageSubscriber;
use bus::run::RunContext;
use geometry::{Ct, Point, Rigid, Tool};
use phantom::Phantom;
use recorder::read::seek::Session;
use serde_json::Value;
use tracker_proc::probe::SimulatedProbe;

/// Above the left hip bone, held still, looking straight back; the probe's image lies along the body's circumference.
const HELD: &str = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n0,0.7071067811865476,-0.7071067811865476,0,0,90,-95,-80\n";

fn scene() -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n")
        + "[tracker.room.gesture]\nfile = \"held.csv\"\n\
           [tracker.room.probe]\nradius_mm = 50\ndepth_mm = 100\npixel_mm = 0.5\nlag_ms = 60\nrate_hz = 5\n"
}

/// The image that the scene's probe makes of the generated patient, by the libraries alone.
fn expected(number: u64) -> Vec<u8> {
    let text = scene();
    let scene = scene::Scene::parse(&text, std::path::Path::new("s.toml")).unwrap();
    let scene::TrackerSource::OperatingRoom(room) = scene.tracker.source else {
        panic!("another source");
    };
    let mut probe = SimulatedProbe::new(room.probe.unwrap(), scene.seed).unwrap();
    let patient = Phantom::new(scene.seed);
    let half = 0.5_f64.sqrt();
    let held: Rigid<Ct, Tool> = geometry::checked::rigid([half, -half, 0.0, 0.0], [90.0, -95.0, -80.0], 1e-9).unwrap();
    let tissue = |[x, y, z]: [f64; 3]| patient.hu(Point::new(x, y, z));
    probe.image(&tissue, held, number).unwrap()
}

#[test]
fn images_of_a_probe_are_recorded_and_replayed_bit_for_bit() {
    let world = World::new();
    world.file("held.csv", HELD);
    let pilot = world.start(&world.file("s.toml", &scene()), &world.path("out"), "default");
    pilot.wait_live();
    let (first, grey) = first_image(&world, "default");
    // The very image of the patient, and no black one.
    assert_eq!(grey, expected(first.seq));
    assert!(grey.iter().filter(|level| **level > 60).count() > grey.len() / 20);
    // Stamped late by the lag, by a clock of its own that starts with the script.
    assert_eq!(first.t_device_ns, 200_000_000 * first.seq as i64 + 60_000_000);
    assert!(first.t_publish_ns >= first.t_capture_ns);
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(pilot.stop().success());

    let session = world.path("out/session.mcap");
    let images: Vec<_> = Session::open(&session)
        .unwrap()
        .us_images_from(0)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert!(images.len() >= 8, "{} images", images.len());
    assert!(images.iter().zip(0..).all(|(image, number)| image.header.seq == number));
    assert_eq!(images[first.seq as usize].grey, grey);

    // Again: each image that comes is one that was recorded.
    let recorded: BTreeMap<u64, _> = images.iter().map(|image| (image.header.seq, image)).collect();
    let out = world.path("again");
    let arguments = [
        "replay",
        session.to_str().unwrap(),
        "--headless",
        "--loop",
        "--run",
        "replay",
        "--out",
    ];
    let mut command = world.command("pilot");
    let child = command.args(arguments).arg(out).spawn().unwrap();
    let again = crate::support::Pilot::of(&world, "replay", child);
    again.wait_for("a replayed view", |status| {
        let is_shown = |view: &Value| view["state"] == "replay";
        status["views"].as_array().unwrap().iter().any(is_shown)
    });
    let bus = Bus::join(&RunContext::load(&world.run_dir("replay")).unwrap()).unwrap();
    let subscriber = UsImageSubscriber::open(&bus).unwrap();
    for _ in 0..5 {
        let image = wait_for("a replayed image", || subscriber.next().unwrap());
        let before = recorded[&image.header().seq];
        assert_eq!((*image.header(), image.grey()), (before.header, &before.grey[..]));
    }
    again.stop();
}

fn first_image(world: &World, run: &str) -> (UsImageHeader, Vec<u8>) {
    let bus = Bus::join(&RunContext::load(&world.run_dir(run)).unwrap()).unwrap();
    let subscriber = UsImageSubscriber::open(&bus).unwrap();
    let image = wait_for("an image", || subscriber.next().unwrap());
    (*image.header(), image.grey().to_vec())
}
