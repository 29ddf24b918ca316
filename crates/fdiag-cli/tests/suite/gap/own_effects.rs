//! Effects of one's own, out of a file.

use crate::gap::desk::{Desk, refuses};

const BRUSH: &str = r#"
[brush]
side = "force"
at = ["rail"]
law = "-f*tanh(v/0.01)"
family = "friction"

[brush.parameters]
f = { size = 0.2, unit = "N" }
"#;

#[test]
fn an_effect_of_a_file_is_tried_and_named() {
    let desk = Desk::new();
    desk.put("own.toml", BRUSH);
    let output =
        desk.gap(&["--effects", "own.toml", "--only", "brush", "--only", "viscous-friction"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = desk.report();
    let first = &report["diagnosis"]["causes"][0];
    assert_eq!(first["label"], "brush");
    assert_eq!(first["family"], "friction");
    assert_eq!(first["site"]["name"], "rail");
    assert_eq!(report["settings"]["effects"][0], "brush at rail: -f*tanh(v/0.01)");
}

#[test]
fn what_is_wrong_in_the_file_is_said() {
    let desk = Desk::new();
    for (from, to, parts) in [
        ("rail", "rai", &["effect `brush`: at: ", "did you mean `rail`?", "found `rai`"][..]),
        ("tanh(v/", "tanh(w/", &["effect `brush`: law: ", "found `w`"]),
        ("-f*", "-(f + 1)*", &["law: expected `0` where all strengths are 0"]),
        ("tanh(v/0.01)", "tanh(v/0.01", &["own.toml: effect `brush`: law: "]),
        ("size", "sice", &["own.toml, line 9", "`sice`"]),
    ] {
        desk.put("own.toml", &BRUSH.replacen(from, to, 1));
        refuses(&desk, &desk.gap(&["--effects", "own.toml"]), 3, parts);
    }
    for empty in ["", "\n\n", "# [brush]\n# side = \"force\"\n"] {
        desk.put("own.toml", empty);
        let parts = ["own.toml", "there is no effect in it"];
        refuses(&desk, &desk.gap(&["--effects", "own.toml"]), 3, &parts);
    }
    refuses(&desk, &desk.gap(&["--effects", "none.toml"]), 3, &["none.toml"]);
}
