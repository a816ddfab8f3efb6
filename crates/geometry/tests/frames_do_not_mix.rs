//! Chains of wrong frames do not compile, and the compiler names the two frames.
//!
//! `TRYBUILD=overwrite cargo test -p geometry --test frames_do_not_mix` writes the messages anew, for another compiler.

#[test]
fn wrong_chains_do_not_compile() {
    trybuild::TestCases::new().compile_fail("tests/ui/*.rs");
}
