#[test]
fn first() {
    let plan = study::plan::Plan::load(&[std::env::var("PLAN").unwrap().into()]).unwrap();
    let out = std::path::PathBuf::from(std::env::var("OUT").unwrap());
    let done = study::run::run(&plan, &out, 1).unwrap();
    eprintln!("{:?} {}", done.operations, done.took_s);
}
