//! The software of others: where it comes from, and under what licence.

use serde_json::Value;

use crate::floors::packages;

/// Licences that ask for no more than that they go along, and MPL-2.0, which asks for its own files alone.
const ALLOWED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MPL-2.0",
    // Fonts, which may be embedded.
    "OFL-1.1",
    "Ubuntu-font-1.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Whether what is allowed satisfies an SPDX expression; `/` is how older packages write OR.
fn allowed(expression: &str) -> bool {
    let text = expression.replace('/', " OR ");
    let mut depth = 0;
    // Splits at a word outside brackets.
    let mut split = |word: &str| -> Vec<String> {
        let mut parts = vec![String::new()];
        for token in text.replace('(', " ( ").replace(')', " ) ").split_whitespace() {
            depth += i32::from(token == "(") - i32::from(token == ")");
            match token == word && depth == 0 {
                true => parts.push(String::new()),
                false => {
                    let part = parts.last_mut().unwrap();
                    part.push_str(if part.is_empty() { "" } else { " " });
                    part.push_str(token);
                }
            }
        }
        parts
    };
    let (any, all) = (split("OR"), split("AND"));
    match (&any[..], &all[..]) {
        ([_, _, ..], _) => any.iter().any(|part| allowed(part)),
        (_, [_, _, ..]) => all.iter().all(|part| allowed(part)),
        ([one], _) => match one.strip_prefix("( ").and_then(|inner| inner.strip_suffix(" )")) {
            Some(inner) => allowed(inner),
            None => ALLOWED.contains(&one.as_str()),
        },
        _ => false,
    }
}

#[test]
fn everything_of_others_is_from_the_registry_under_a_licence_that_lets_us_pass_it_on() {
    let packages = packages("--locked");
    assert!(packages.len() > 200, "{}", packages.len());
    let wrong: Vec<String> = packages
        .iter()
        .filter(|package| package["source"] != Value::Null)
        .filter(|package| package["source"] != REGISTRY || !package["license"].as_str().is_some_and(allowed))
        .map(|package| {
            format!(
                "{} {}: {}, {}",
                package["name"], package["version"], package["license"], package["source"]
            )
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn expressions_are_read_as_spdx_has_them() {
    for good in [
        "MIT",
        "MIT/GPL-3.0",
        "GPL-2.0 OR (MIT AND ISC)",
        "(MIT OR Apache-2.0) AND Unicode-3.0",
    ] {
        assert!(allowed(good), "{good}");
    }
    for bad in [
        "",
        "GPL-3.0",
        "MIT AND GPL-3.0",
        "(MIT OR Apache-2.0) AND GPL-3.0",
        "GPL-2.0 OR (MIT AND GPL-3.0)",
    ] {
        assert!(!allowed(bad), "{bad}");
    }
}
