//! A whole run with the gateway in it.

use std::net::{SocketAddr, TcpListener};

use igtl::{Kind, ToolStatus, Version};
use phantom::Phantom;
use serde_json::{Value, json};

use crate::peers;
use crate::poses::{get, transform};
use crate::rig::Raw;
use crate::support::{SMALL, World, all_live, is_alive, kill_9, pid_in, report, wait_for};

fn note(status: &Value) -> Option<String> {
    let all = status["processes"].as_array()?;
    let gateway = all.iter().find(|process| process["name"] == "gateway")?;
    Some(gateway["note"].as_str()?.to_owned())
}

fn address(status: &Value) -> Option<SocketAddr> {
    note(status)?.split_once(": ")?.0.parse().ok()
}

/// The places of some voxels of the generated patient, LPS mm, and their values, by the phantom itself.
fn known_places(mirrored: bool) -> (Vec<[f64; 3]>, Vec<i64>) {
    let patient = Phantom::new(1);
    let grid = patient.grid([6.0; 3]).unwrap();
    let [nx, ny, nz] = grid.dims();
    let (mut places, mut values) = (Vec::new(), Vec::new());
    let mut slice = vec![0; (nx * ny) as usize];
    for z in (0..nz).step_by(9) {
        patient.fill_slice(&grid, z, &mut slice);
        for (y, x) in (0..ny).step_by(5).flat_map(|y| (0..nx).step_by(4).map(move |x| (y, x))) {
            let rows = grid.ct_from_voxel().rows();
            let voxel = [x, y, z].map(f64::from);
            places.push(rows.map(|row| row[0] * voxel[0] + row[1] * voxel[1] + row[2] * voxel[2] + row[3]));
            let at = if mirrored { nx - 1 - x } else { x };
            values.push(slice[(y * nx + at) as usize].into());
        }
    }
    (places, values)
}

#[test]
fn a_run_is_looked_on_by_others_and_the_death_of_their_server_costs_it_nothing() {
    let world = World::new();
    let scene = world.file("s.toml", &format!("{SMALL}[gateway]\naddress = \"127.0.0.1:0\"\n"));
    let pilot = world.start(&scene, &world.path("out"), "looked");
    let status = pilot.wait_for("the gateway", |status| all_live(status) && address(status).is_some());
    let first = address(&status).unwrap();
    if let Some(peer) = peers::cxx() {
        let lines = peers::lines(peers::start(peer, first, &["listen", "60", "GET_POINT"]));
        let poses = lines.iter().filter(|line| line.starts_with("TRANSFORM ToolToRas"));
        assert!(poses.count() > 20, "{lines:#?}");
        let said = |words: &str| lines.iter().any(|line| line.contains(words));
        assert!(
            said("LIVE; SIMULATED TRACKER") && said("STRING Workflow") && said("POINT Targets"),
            "{lines:#?}"
        );
    }
    let (places, values) = known_places(false);
    let differing = values
        .iter()
        .zip(known_places(true).1)
        .filter(|(a, b)| **a != *b)
        .count();
    // A patient whose sides were exchanged would be told from this one.
    assert!(differing > 100, "{differing} of {}", values.len());
    let file = world.file("places.json", &json!(places).to_string());
    if let Some(child) = peers::python(first, &["image", "Volume", file.to_str().unwrap()]) {
        let found = peers::printed(child);
        let found: Vec<i64> = found["values"]
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_i64().unwrap())
            .collect();
        assert_eq!(found, values);
    }
    let before = pid_in(&status, "gateway").unwrap();
    kill_9(before);
    let status = pilot.wait_for("another gateway", |status| {
        pid_in(status, "gateway").is_some_and(|pid| pid != before) && address(status).is_some_and(|now| now != first)
    });
    assert!(all_live(&status), "{status:#?}");
    // Who comes now is told what holds, also where the loader had said it long before.
    let mut client = Raw::dial(address(&status).unwrap());
    client.wait_for("a pose", |message| (message.device == "ToolToRas").then_some(()));
    pilot.stop();
    let report = report(&world.path("out"));
    let problems = report["problems"].as_array().unwrap();
    // That it died is said, and nothing else is wrong with the run.
    assert!(
        problems
            .iter()
            .all(|problem| problem.as_str().unwrap().contains("gateway")),
        "{problems:#?}"
    );
    assert!(!problems.is_empty());
}

#[test]
fn a_port_that_another_program_has_is_said_and_asked_for_again_and_the_run_goes_on() {
    let other = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = other.local_addr().unwrap();
    let world = World::new();
    let scene = world.file("s.toml", &format!("{SMALL}[gateway]\naddress = \"{taken}\"\n"));
    let pilot = world.start(&scene, &world.path("out"), "taken");
    pilot.wait_for("the reason", |status| {
        all_live(status) && note(status).is_some_and(|note| note.starts_with("NOT SERVING") && note.contains("in use"))
    });
    drop(other);
    pilot.wait_for("the port", |status| address(status) == Some(taken));
    assert!(pilot.stop().success());
}

/// The kernel killed the gateway with the pilot: the last that a client was told was a pose that is valid.
#[test]
fn a_pilot_that_is_killed_leaves_no_client_with_a_valid_pose() {
    let world = World::new();
    let scene = world.file("s.toml", &format!("{SMALL}[gateway]\naddress = \"127.0.0.1:0\"\n"));
    let pilot = world.start(&scene, &world.path("out"), "orphan");
    let status = pilot.wait_for("the gateway", |status| all_live(status) && address(status).is_some());
    let gateway = pid_in(&status, "gateway").unwrap();
    let mut client = Raw::dial(address(&status).unwrap());
    client.send(&get(Kind::Status, Version::Two));
    client.wait_for("a valid pose", |message| {
        transform(message)
            .filter(|(status, ..)| *status == ToolStatus::Ok)
            .map(|_| ())
    });
    kill_9(u64::from(pilot.child.id()));
    let mut last = None;
    while let Some(message) = client.next() {
        let of_tool = transform(&message).filter(|_| message.device == "ToolToRas");
        last = of_tool.map(|(status, _, why)| (status, why)).or(last);
    }
    assert_eq!(last, Some((ToolStatus::Missing, "ENDED: the run has ended".to_owned())));
    wait_for("the gateway to be gone", || (!is_alive(gateway)).then_some(()));
}
