//! For how long a measurement may stand still, by what the scene says of its source.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use std::path::Path;
use std::time::Duration;

use scene::Scene;

fn frozen(text: &str) -> Option<Duration> {
    Scene::parse(text, Path::new("scene.toml")).unwrap().frozen()
}

/// An old recording's simulator without noise was called frozen wherever its tool was at rest.
#[test]
fn a_simulator_without_noise_may_stand_still_and_nobody_else() {
    let limit = Some(Duration::from_millis(500));
    assert_eq!(frozen(""), limit);
    assert_eq!(frozen("[limits]\nfrozen_ms = 70.0\n"), Some(Duration::from_millis(70)));
    let simulated = |keys: &str| frozen(&format!("[tracker]\n{keys}"));
    assert_eq!(simulated("noise_mm = 0.0\nnoise_deg = 0.0\n"), None);
    for keys in [
        "noise_mm = 0.0\n",
        "noise_deg = 0.0\n",
        "source = \"external\"\nnoise_mm = 0.0\nnoise_deg = 0.0\n",
    ] {
        assert_eq!(simulated(keys), limit, "{keys}");
    }
    let room = |keys: &str| {
        simulated(&format!(
            "source = \"operating-room\"\n[tracker.room.localizer]\n{keys}"
        ))
    };
    assert_eq!(room("across_mm = 0.1\n"), limit);
    assert_eq!(room("across_mm = 0.0\ndepth_mm = 0.0\n"), None);
    // Steps in which the noise drowns.
    assert_eq!(room("across_mm = 0.1\ndepth_mm = 0.1\nquantisation_mm = 0.5\n"), None);
    assert_eq!(room("across_mm = 0.1\ndepth_mm = 0.1\nquantisation_mm = 0.2\n"), limit);
}
