//! tmp
fn main() {
    let mut config = fdiag::engine::EngineConfig::default();
    let a: Vec<String> = std::env::args().collect();
    config.seeds = a[1].parse().unwrap();
    if let Some(f) = a.get(2) { config = toml::from_str(&std::fs::read_to_string(f).unwrap()).unwrap(); config.seeds = a[1].parse().unwrap(); }
    let b = fdiag::engine::Benchmark::new(config).unwrap();
    let t = std::time::Instant::now();
    let s = b.study(|| ()).unwrap();
    println!("{:#?}", s.summary);
    println!("failed {:?} {:?}", s.failed, t.elapsed());
}
