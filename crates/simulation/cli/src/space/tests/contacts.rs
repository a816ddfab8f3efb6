//! Organs that slide along what is rigid.

use nalgebra::{Matrix3, Vector3};
use serde_json::Value;

use super::super::Space;
use super::READ;
use super::maps::{BALL, FLOOR, SCENE, folder};

/// The ball before its floor, held by nothing but a bath, and kept out of the floor or not.
fn pushed(contact: bool) -> (Value, String) {
    let attachment = "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"\n";
    assert!(SCENE.contains(attachment));
    let table = "[[contacts]]\norgan = \"ball\"\nwith = [\"floor\"]\nsmoothing = 2.0\nball = 3.0\n";
    // A soft bath: the ball goes with the tube.
    let text = SCENE
        .replace(attachment, if contact { table } else { "" })
        .replace("young = 1e-3", "young = 1e-4");
    let (folder, path) = folder(&Matrix3::identity(), 0.0);
    let space = Space::new(text, &path, None, READ).unwrap();
    let described = space.described();
    space.run(folder.path(), &mut |line| println!("{line}")).unwrap();
    let json = std::fs::read(folder.path().join("result.json")).unwrap();
    (serde_json::from_slice(&json).unwrap(), described)
}

fn last(json: &Value) -> &Value {
    json["states"].as_array().unwrap().last().unwrap()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|k, _| value[k].as_f64().unwrap())
}

#[test]
fn a_ball_that_is_pushed_onto_a_floor_stays_out_of_it() {
    let (json, described) = pushed(true);
    assert!(described.contains("contact    ball: kept out of floor"), "{described}");
    assert!(
        described.contains("contact of the tube with what keeps organs out (floor)"),
        "{described}"
    );
    // At the first touch nothing presses.
    assert_eq!(json["states"][0]["on_rigid"][0]["force_size"].as_f64().unwrap(), 0.0);
    let state = last(&json);
    let on = &state["on_rigid"][0];
    let (on_floor, on_tube) = (vector(&on["force"]), vector(&state["on_tube"]["force"]));
    // Towards the back, and without friction across it only: the floor is a plane but for its voxels' edges.
    assert!(on_floor.y > 0.5 * on_tube.norm(), "{on_floor:?} {on_tube:?}");
    assert!(on_floor.x.hypot(on_floor.z) < 0.1 * on_floor.y, "{on_floor:?}");
    assert!(on["depth"].as_f64().unwrap() < 1e-4);
    // All outer forces on the ball, the floor's among them, sum to nothing.
    assert!(state["equilibrium"]["balance"].as_f64().unwrap() < 1e-6);
    // Without the contact the bath gives way, and the ball goes into the floor.
    let (free, described) = pushed(false);
    assert!(
        described.contains("(floor): it holds and is no obstacle"),
        "{described}"
    );
    let [kept, gone] = [&json, &free].map(|json| last(json)["area_in_rigid"].as_f64().unwrap());
    assert!(gone > 100.0 && kept < 0.5 * gone, "{kept} {gone}");
    let force = |json| vector(&last(json)["on_tube"]["force"]).norm();
    assert!(force(&json) > 1.5 * force(&free));
    assert!(FLOOR[0] >= BALL.1);
}
