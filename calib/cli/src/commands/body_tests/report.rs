//! `calib rom` on real tool definitions, `calib f2554` on what it simulates.

use calib::f2554::phantom;

use super::*;

#[test]
fn tool_definitions_are_read_and_the_rod_refused() {
    let Some(folder) = shared("tracker-plus/NdiToolDefinitions") else {
        return;
    };
    let mut read = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let info = calib(&format!("calib rom info {}", path.display())).unwrap();
        let marker = calib(&format!("calib marker --rom {} --toml", path.display()));
        if path.ends_with("8700248.rom") {
            let (refused, error) = (info.refused.unwrap(), marker.unwrap_err());
            for words in ["8700248", "determine no pose", "line"] {
                assert!(refused.contains(words) && error.contains(words), "{refused} {error}");
            }
            continue;
        }
        assert!(
            info.refused.is_none() && info.text.contains("4 markers"),
            "{}",
            info.text
        );
        let scene: toml::Table = marker.unwrap().text.parse().unwrap();
        assert_eq!(
            scene["tracker"]["room"]["marker"]["emitters"].as_array().unwrap().len(),
            4
        );
        read += 1;
    }
    assert_eq!(read, 6);
}

#[test]
fn a_simulated_report_can_be_written_and_measured_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let line = format!(
        "calib f2554 --simulate 7 --data {} --png {} --out {}",
        at("d.csv"),
        at("t.png"),
        at("r.json")
    );
    let simulated = calib(&line).unwrap();
    assert!(
        simulated.text.contains("5 places") && simulated.refused.is_none(),
        "{}",
        simulated.text
    );
    assert!(fs::read(at("t.png")).unwrap().starts_with(b"\x89PNG"));
    let divots: String = phantom()
        .iter()
        .enumerate()
        .fold("divot,x,y,z\n".to_owned(), |text, (i, p)| {
            let [x, y, z] = p.mm();
            text + &format!("{i},{x},{y},{z}\n")
        });
    let drawn = write(&folder, "phantom.csv", &divots);
    let measured = calib(&format!("calib f2554 {} --phantom {drawn} --json", at("d.csv"))).unwrap();
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    let (a, b) = (json(&measured.text), json(&fs::read_to_string(at("r.json")).unwrap()));
    assert_eq!(
        (&a["places"], &a["distances"], &a["id"]),
        (&b["places"], &b["distances"], &b["id"])
    );
    let refused = calib("calib f2554 --simulate 7 --max-distance-mm 0.01").unwrap();
    assert!(
        refused.refused.unwrap().contains("--max-distance-mm 0.01: found"),
        "{}",
        refused.text
    );
    let fewer = write(
        &folder,
        "phantom.csv",
        &divots.lines().take(5).map(|l| format!("{l}\n")).collect::<String>(),
    );
    let error = calib(&format!("calib f2554 {} --phantom {fewer}", at("d.csv"))).unwrap_err();
    assert!(error.contains("the phantom has 4, counted from 0"), "{error}");
}
