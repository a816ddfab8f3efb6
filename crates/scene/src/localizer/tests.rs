use std::path::Path;

use super::super::Scene;
use super::*;

const HEAD: &str = "[tracker]\nsource = \"markers\"\n";

fn parsed(text: &str) -> Result<Scene, String> {
    let text = format!("{HEAD}{text}");
    Scene::parse(&text, Path::new("s.toml")).map_err(|error| error.to_string())
}

#[test]
fn a_peer_states_what_it_saw_unless_the_scene_says_otherwise() {
    let scene = parsed("[localizer]\nkind = \"openigtlink\"\naddress = \"[::1]:18944\"").unwrap();
    let spec = scene.localizer.unwrap();
    assert_eq!((spec.name.as_str(), spec.clock), ("[::1]:18944", StampRule::Mapped));
    let LinkSpec::OpenIgtLink(link) = spec.link else {
        panic!("{:?}", spec.link)
    };
    assert_eq!((link.peer, link.status), (Peer::Auto, StatusRule::Required));
    assert_eq!((link.stream, link.max_rotation_error), (None, 2e-3));
    assert_eq!(link.least_distance_mm, 10.0);
    assert_eq!(link.silent, scene.limits.silent);
    assert!(parsed("").unwrap().localizer.is_none());
}

#[test]
fn tools_of_ndi_are_the_markers_of_the_tracker() {
    let tools = "[[localizer.tools]]\nname = \"ball\"\nrom = \"a.rom\"\n[[localizer.tools]]\nname = \"patient\"\nrom = \"/b.rom\"\n";
    let head = "[localizer]\nkind = \"ndi\"\naddress = \"vega.local:8765\"\n";
    let spec = parsed(&format!("{head}{tools}")).unwrap().localizer.unwrap();
    let LinkSpec::Ndi(link) = spec.link else {
        panic!("{:?}", spec.link)
    };
    let paths: Vec<_> = link.tools.iter().map(|(_, path)| path.to_str().unwrap()).collect();
    assert_eq!(paths, ["a.rom", "/b.rom"]);
    let error = parsed(&format!("[tracker.markers]\nmarker = \"bell\"\n{head}{tools}")).unwrap_err();
    assert!(
        error.contains("key tracker.markers.marker: found \"bell\"; allowed: the name of one of localizer.tools"),
        "{error}"
    );
}

#[test]
fn what_cannot_be_is_refused_with_its_key() {
    let head = "[localizer]\naddress = \"a:1\"\n";
    for (text, words) in [
        (
            "[localizer]\nkind = \"openigtlink\"\naddress = \"a\"".to_owned(),
            "key localizer.address: found \"a\"; allowed: host:port",
        ),
        (
            "[localizer]\nkind = \"openigtlink\"\naddress = \"a:0\"".to_owned(),
            "localizer.address",
        ),
        (
            "[localizer]\nkind = \"openigtlink\"\naddress = \"a:+5\"".to_owned(),
            "localizer.address",
        ),
        (
            "[localizer]\nkind = \"openigtlink\"\naddress = \":5\"".to_owned(),
            "localizer.address",
        ),
        (
            "[localizer]\nkind = \"openigtlink\"\naddress = \"a b:5\"".to_owned(),
            "localizer.address",
        ),
        (
            "[localizer]\nkind = \"ndi\"\naddress = \"/dev/ttyUSB0\"".to_owned(),
            "found \"/dev/ttyUSB0\"; allowed: host:port of a network, such as \"192.168.0.30:8765\": serial lines are not dialled",
        ),
        (
            "[localizer]\nkind = \"ndi\"\naddress = \"COM3\"".to_owned(),
            "found \"COM3\"; allowed: host:port of a network, such as \"192.168.0.30:8765\": serial lines are not dialled",
        ),
        (format!("{head}kind = \"polaris\""), "unknown variant `polaris`"),
        (
            format!("{head}kind = \"ndi\""),
            "key localizer.tools: found 0; allowed: 1 to 16 tools",
        ),
        (
            format!("{head}kind = \"ndi\"\npeer = \"v1\""),
            "localizer.peer: found a value; allowed: no such key unless localizer.kind = \"openigtlink\"",
        ),
        (
            format!("{head}kind = \"openigtlink\"\ntools = [{{ name = \"a\", rom = \"b\" }}]"),
            "unless localizer.kind = \"ndi\"",
        ),
        (
            format!("{head}kind = \"openigtlink\"\nstream_ms = 0"),
            "localizer.stream_ms: found 0",
        ),
        (
            format!("{head}kind = \"openigtlink\"\nmax_rotation_error = 1"),
            "localizer.max_rotation_error: found 1",
        ),
        (
            format!("{head}kind = \"openigtlink\"\nleast_distance_mm = -1"),
            "localizer.least_distance_mm: found -1",
        ),
        (
            format!("{head}kind = \"openigtlink\"\nleast_delay_ms = nan"),
            "localizer.least_delay_ms: found NaN",
        ),
        (format!("{head}kind = \"openigtlink\"\nname = \"\""), "localizer.name"),
        (
            format!("{head}kind = \"ndi\"\ntools = [{{ name = \"a\", rom = \"b\" }}, {{ name = \"a\", rom = \"c\" }}]"),
            "found \"a\" a second time",
        ),
        (
            format!("{head}kind = \"ndi\"\ntools = [{{ name = \"a\", rom = \"\" }}]"),
            "localizer.tools.0.rom",
        ),
    ] {
        let error = parsed(&text).unwrap_err();
        assert!(error.contains(words), "{text}\n  gave {error}");
    }
    let text = format!("{head}kind = \"openigtlink\"");
    let error = Scene::parse(&text, Path::new("s.toml")).unwrap_err().to_string();
    assert!(error.contains("unless tracker.source = \"markers\""), "{error}");
}

/// Single markers are emitters of the tracker: one tool on the surgeon's tool, and one on the patient where there is a marker.
#[test]
fn tools_of_ndi_carry_the_emitters_of_the_tracker() {
    let head = "[localizer]\nkind = \"ndi\"\naddress = \"vega.local:8765\"\n";
    let tool = |name: &str, more: &str| format!("[[localizer.tools]]\nname = \"{name}\"\nrom = \"a.rom\"\n{more}");
    let of = |reference: &str, tools: &[String]| {
        let text = format!("[tracker]\nsource = \"emitters\"\n{reference}{head}{}", tools.concat());
        let scene = Scene::parse(&text, Path::new("s.toml")).map_err(|error| error.to_string());
        scene.map(|scene| match scene.localizer.unwrap().link {
            LinkSpec::Ndi(link) => link.single.unwrap(),
            link @ LinkSpec::OpenIgtLink(_) => panic!("{link:?}"),
        })
    };
    let (ball, patient) = (tool("ball", ""), tool("patient", "on = \"patient\"\n"));
    let reference = "[tracker.emitters.reference]\ncone_deg = 80.0\n";
    assert_eq!(
        of(reference, &[patient.clone(), ball.clone()]).unwrap(),
        SingleMarkers {
            tool: "ball".to_owned(),
            patient: Some("patient".to_owned())
        }
    );
    assert_eq!(of("", std::slice::from_ref(&ball)).unwrap().patient, None);
    for (reference, tools, words) in [
        (
            "",
            vec![ball.clone(), patient.clone()],
            "found 1 on the patient; allowed: 0",
        ),
        (reference, vec![ball.clone()], "found 0 on the patient; allowed: 1"),
        (
            reference,
            vec![ball.clone(), tool("other", ""), patient.clone()],
            "found 2 on the tool; allowed: 1",
        ),
    ] {
        let error = of(reference, &tools).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    let error = parsed(&format!("{head}{patient}")).unwrap_err();
    assert!(
        error.contains("localizer.tools.0.on") && error.contains("emitters"),
        "{error}"
    );
    let error = Scene::parse(
        "[tracker]\nsource = \"emitters\"\n[localizer]\nkind = \"openigtlink\"\naddress = \"a:1\"",
        Path::new("s.toml"),
    );
    assert!(error.unwrap_err().to_string().contains("no single markers"));
}

/// A table `[localizer.images]` with these keys behind a name and an orientation.
fn images(keys: &str) -> Result<Scene, String> {
    parsed(&format!(
        "[localizer]\nkind = \"openigtlink\"\naddress = \"a:1\"\n[localizer.images]\nname = \"Image\"\n{keys}"
    ))
}

#[test]
fn images_of_the_peer_say_how_they_are_turned_and_all_of_their_beams_or_nothing() {
    let of = |keys: &str| match images(keys).unwrap().localizer.unwrap().link {
        LinkSpec::OpenIgtLink(link) => link.images.unwrap(),
        LinkSpec::Ndi(link) => panic!("{link:?}"),
    };
    let least = of("orientation = \"MF\"");
    assert_eq!((least.pixel_mm, least.shown), (None, None));
    assert_eq!(least.latest.as_millis(), 300);
    assert_eq!(of("orientation = \"MF\"\nlatest_ms = 80").latest.as_millis(), 80);
    let linear = of("orientation = \"UFA\"\npixel_mm = [0.1, 0.2]\ndepth_mm = 40\nlinear_mm = [0.5, 38, 1]");
    let beams = ShownBeams::Linear {
        from_mm: 0.5,
        to_mm: 38.0,
        face_mm: 1.0,
    };
    assert_eq!(linear.shown, Some((40.0, beams)));
    let convex = "convex = { centre_mm = [50, -40], radius_mm = 60, half_angle_deg = 30 }";
    let curved = of(&format!("orientation = \"MF\"\ndepth_mm = 80\n{convex}"));
    assert!(
        matches!(curved.shown, Some((80.0, ShownBeams::Convex { half_angle_rad, .. })) if half_angle_rad == 30_f64.to_radians())
    );
    let both = format!("orientation = \"MF\"\ndepth_mm = 8\nlinear_mm = [0, 9, 0]\n{convex}");
    for (keys, words) in [
        ("", "orientation"),
        ("orientation = \"mf\"", "localizer.images.orientation: found \"mf\""),
        ("orientation = \"MU\"", "localizer.images.orientation"),
        ("orientation = \"M\"", "localizer.images.orientation"),
        (
            "orientation = \"MF\"\npixel_mm = [0.1, nan]",
            "localizer.images.pixel_mm",
        ),
        (
            "orientation = \"MF\"\npixel_mm = [0.0001, 0.0001]",
            "localizer.images.pixel_mm",
        ),
        (
            "orientation = \"MF\"\ndepth_mm = 40",
            "half of what says where beams run",
        ),
        (
            "orientation = \"MF\"\nlinear_mm = [0, 9, 0]",
            "half of what says where beams run",
        ),
        (
            "orientation = \"MF\"\ndepth_mm = 40\nlinear_mm = [9, 9, 0]",
            "localizer.images.linear_mm",
        ),
        (
            "orientation = \"MF\"\ndepth_mm = 4000\nlinear_mm = [0, 9, 0]",
            "localizer.images.depth_mm",
        ),
        ("orientation = \"MF\"\nlatest_ms = 2001", "localizer.images.latest_ms"),
        ("orientation = \"MF\"\nlatest_ms = nan", "localizer.images.latest_ms"),
        (both.as_str(), "two arrays"),
        (
            "orientation = \"MN\"\ndepth_mm = 40\nlinear_mm = [0, 9, 0]",
            "\"MF\" or \"UF\" where",
        ),
        (
            "orientation = \"FM\"\ndepth_mm = 40\nlinear_mm = [0, 9, 0]",
            "\"MF\" or \"UF\" where",
        ),
    ] {
        let error = images(keys).unwrap_err();
        assert!(error.contains(words), "{keys}: {error}");
    }
    let ndi = "[localizer]\nkind = \"ndi\"\naddress = \"a:1\"\n[localizer.images]\nname = \"I\"\norientation = \"MF\"";
    assert!(parsed(ndi).unwrap_err().contains("localizer.images"));
}
