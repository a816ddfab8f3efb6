//! Scene files with random changes: each is accepted or refused with a place, in bounded time, and none is a panic.

use std::path::{Path, PathBuf};

use super::check;

/// Numbers that programs get wrong.
const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1e-300",
    "1e300",
    "nan",
    "inf",
    "-inf",
    "1e-12",
    "-0.0",
    "0.5",
    "9223372036854775807",
    "100000",
    "3",
    "1e9",
];

/// A generator of its own: the same changes each time.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

fn scenes() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../config/solids");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
        .iter()
        .map(|path| std::fs::read_to_string(path).unwrap())
        .collect()
}

/// Where numbers stand in a text: their bytes.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let digit = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | 'e');
    let mut found = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices() {
        match (start, digit(c)) {
            (None, true) => start = Some(at),
            (Some(from), false) => {
                if text[from..at].contains(|c: char| c.is_ascii_digit()) {
                    found.push(from..at);
                }
                start = None;
            }
            _ => {}
        }
    }
    found
}

/// One change: a number, a line gone or twice, a piece of another scene, bytes.
fn mutate(text: &mut String, other: &str, random: &mut Random) {
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    match random.below(6) {
        0 | 1 => {
            let all = numbers(text);
            if let Some(range) = all.get(random.below(all.len())) {
                text.replace_range(range.clone(), NUMBERS[random.below(NUMBERS.len())]);
            }
        }
        2 => {
            let gone = random.below(lines.len());
            let kept = lines.iter().enumerate().filter(|(k, _)| *k != gone);
            *text = kept.map(|(_, line)| format!("{line}\n")).collect();
        }
        3 => {
            let twice = random.below(lines.len());
            let line = lines.get(twice).cloned().unwrap_or_default();
            text.push_str(&line);
            text.push('\n');
        }
        4 => {
            let pieces: Vec<&str> = other.split("\n\n").collect();
            text.push_str("\n\n");
            text.push_str(pieces[random.below(pieces.len())]);
        }
        _ => {
            let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
            if let Some(at) = places.get(random.below(places.len())) {
                let bytes = ["[", "]", "\"", "\n", "=", "{", "\u{0}", "-", "9", "é"];
                text.insert_str(*at, bytes[random.below(bytes.len())]);
            }
        }
    }
}

#[test]
fn scenes_with_random_changes_are_checked_without_a_panic() {
    let (scenes, mut random) = (scenes(), Random(7));
    let (mut accepted, mut refused) = (0, 0);
    // More by hand: TROCAR_MUTATIONS=20000 cargo test -p simulation-cli mutated
    let count = std::env::var("TROCAR_MUTATIONS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(600);
    for round in 0..count {
        let mut text = scenes[random.below(scenes.len())].clone();
        let other = scenes[random.below(scenes.len())].clone();
        for _ in 0..=random.below(3) {
            mutate(&mut text, &other, &mut random);
        }
        match check(text, Path::new("mutated.toml")) {
            Ok(words) => {
                assert!(words.contains("unknowns"), "{round}: {words}");
                accepted += 1;
            }
            Err(error) => {
                assert!(
                    error.contains("mutated.toml") && error.contains("line "),
                    "{round}: {error}"
                );
                refused += 1;
            }
        }
    }
    assert!(
        accepted > count / 20 && refused > count / 20,
        "{accepted} accepted, {refused} refused"
    );
}
