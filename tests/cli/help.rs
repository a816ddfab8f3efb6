//! What the programs say of themselves.

#[path = "../support/programs.rs"]
mod programs;
mod trade;

use clap::Command;

/// Every command that does something, with the words that lead to it.
fn commands(command: Command, words: &str) -> Vec<(String, Command)> {
    let words = format!("{words} {}", command.get_name()).trim().to_owned();
    let below: Vec<Command> = command.get_subcommands().cloned().collect();
    match below.is_empty() {
        true => vec![(words, command)],
        false => below.into_iter().flat_map(|below| commands(below, &words)).collect(),
    }
}

/// The example names the command as it is typed, so that it can be copied.
#[test]
fn every_command_has_an_example() {
    let all: Vec<_> = programs::all()
        .into_iter()
        .flat_map(|program| commands(program, ""))
        .collect();
    assert!(all.len() > 45, "{}", all.len());
    let without = all.into_iter().filter_map(|(words, mut command)| {
        let help = command.render_long_help().to_string();
        let example = help
            .split_once("Example")
            .is_some_and(|(_, examples)| examples.contains(&words));
        (!example).then_some(words)
    });
    let without: Vec<_> = without.collect();
    assert!(without.is_empty(), "{without:#?}");
}
