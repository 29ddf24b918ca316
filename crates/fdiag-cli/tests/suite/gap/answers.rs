//! What it says and writes.

use std::{
    fs,
    process::{Command, Stdio},
    time::Duration,
};

use serde_json::json;
use sha2::{Digest, Sha256};

use crate::gap::desk::{Desk, FEW, refuses, stdout};

#[test]
fn the_answer_is_one_sentence_and_tables() {
    let desk = Desk::new();
    let output = desk.gap(&["--held-out", "friday.csv"]);
    let text = stdout(&output);
    assert!(output.status.success(), "{output:?}");
    let headline = text.lines().next().unwrap();
    assert!(headline.starts_with("Coulomb friction at rail ("), "{headline}");
    for part in [" N", ", p ", "held-out data", "% ("] {
        assert!(headline.contains(part), "{headline}");
    }
    for title in ["Mechanism and place", "Cause", "How far, on held-out data"] {
        assert!(text.contains(title), "{text}");
    }
    assert!(output.stderr.is_empty(), "nothing is said to nobody: {output:?}");
    let page = desk.read("out/report.html");
    assert!(page.contains("<svg") && page.contains("Coulomb friction at rail"));
    // Behind the first pictures are the inputs, and what is left of each output.
    for title in ["Input force", "Residual of speed", "Autocorrelation, speed"] {
        assert!(page.contains(title), "{title}");
    }
    let outside = ["src=", "@import", "url(", "http://", "https://"];
    let page = page.replace("url(#", "").replace("http://www.w3.org/2000/svg", "");
    assert!(outside.iter().all(|o| !page.contains(o)), "the page needs something from elsewhere");
    for link in page.split("href=\"").skip(1) {
        let (file, _) = link.split_once('"').unwrap();
        assert!(desk.path("out").join(file).is_file(), "{file} is not beside the page");
    }
    let log = Sha256::digest(fs::read(desk.path("friday.csv")).unwrap());
    let hash = u64::from_be_bytes(*log.first_chunk().unwrap());
    assert!(page.contains(&format!("SHA-256 {hash:016x}…")), "where the page is from");
    let mut files: Vec<String> = fs::read_dir(desk.path("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["patched.toml", "report.html", "report.json"]);
    let report = desk.report();
    assert_eq!(report["version"], 2);
    assert_eq!(report["headline"], headline);
    assert_eq!(report["models"][0]["file"], "patched.toml");
}

#[test]
fn json_is_printed_as_it_is_written() {
    let desk = Desk::new();
    let printed = stdout(&desk.gap(&[&FEW[..], &["--json"]].concat()));
    assert_eq!(printed.trim_end(), desk.read("out/report.json").trim_end());
    // Without --held-out the last third of the log is held out.
    let logs = desk.report()["inputs"]["logs"].clone();
    assert_eq!((&logs[0]["samples"], &logs[0]["role"]), (&json!([0, 670]), &"fit".into()));
    assert_eq!((&logs[1]["samples"], &logs[1]["role"]), (&json!([670, 1000]), &"held-out".into()));
}

/// A column without any unit is in that of the model, whether the map names it or not.
#[test]
fn what_has_no_unit_has_that_of_the_model() {
    let desk = Desk::new();
    let bare = |text: &str| {
        let header = "time [s],force [N],speed [m/s]";
        assert!(text.contains(header), "{text}");
        text.replace(header, "time,push,speed")
    };
    let plain = desk.gap(&FEW);
    assert!(plain.status.success(), "{plain:?}");
    desk.put("monday.csv", &bare(&desk.read("monday.csv")));
    desk.put("map.toml", "inputs = [{ name = \"force\", column = \"push\" }]\n");
    let mapped = desk.gap(&[&FEW[..], &["--columns", "map.toml"]].concat());
    assert!(mapped.status.success(), "{mapped:?}");
    assert_eq!(stdout(&mapped).lines().next(), stdout(&plain).lines().next());
    desk.put("map.toml", "inputs = [{ name = \"force\", column = \"push\", unit = \"kN\" }]\n");
    let otherwise = desk.gap(&[&FEW[..], &["--columns", "map.toml"]].concat());
    assert_ne!(stdout(&otherwise).lines().next(), stdout(&plain).lines().next());
}

/// Same seed, same answer, whatever the number of threads.
#[test]
fn threads_change_nothing() {
    let desk = Desk::new();
    let mut reports = ["1", "2", "3"].map(|threads| {
        assert!(desk.gap(&["--threads", threads]).status.success());
        (desk.read("out/report.json"), desk.read("out/report.html"), desk.read("out/patched.toml"))
    });
    for (json, page, _) in &mut reports {
        // The footer has the command and the time.
        page.truncate(page.find("<footer>").unwrap());
        let timing = json.find("\"timing\"").unwrap();
        assert!(json[timing..].matches('{').count() == 1, "timing comes last");
        json.truncate(timing);
    }
    assert_eq!(reports[0], reports[1]);
    assert_eq!(reports[0], reports[2]);
}

/// The patched model is a model like any other, and before it is what after was.
#[test]
fn the_patched_model_closes_the_gap() {
    let desk = Desk::new();
    let held_out = ["--held-out", "friday.csv"];
    assert!(desk.gap(&held_out).status.success());
    let first = desk.report();
    let text = desk.read("out/patched.toml");
    assert!(text.starts_with("# Written by `fdiag gap`: the model with Coulomb friction at rail"));
    let plain = ["--model", "out/patched.toml", "--log", "monday.csv", "--out", "again"];
    let again = desk.run(&[&plain[..], &held_out].concat());
    assert!(again.status.success(), "{again:?}");
    let second = desk.report_in("again");
    assert_eq!(second["diagnosis"]["verdict"], "no-gap");
    for (a, b) in [
        (
            &first["diagnosis"]["held_out"][0]["after"][0],
            &second["diagnosis"]["held_out"][0]["nominal"][0],
        ),
        (
            &first["location"]["channels"][0]["after"]["value"],
            &second["location"]["channels"][0]["nominal"]["value"],
        ),
    ] {
        let (Some(a), Some(b)) = (a.as_f64(), b.as_f64()) else {
            assert!(a.is_null() && b.is_null());
            continue;
        };
        // The same simulation, but for the initial state of the held-out run, which is estimated
        // from a part of it around another prior mean.
        assert!((a - b).abs() < 0.01 * a, "{a} {b}");
    }
}

#[test]
fn what_the_user_knows_counts() {
    let desk = Desk::new();
    let known = ["--tolerance", "d=0", "--noise", "speed=0.005", "--exclude", "coulomb-friction"];
    let more = ["--exclude", "input-delay@force", "--horizon", "2", "--seed", "7"];
    assert!(desk.gap(&[&known[..], &more].concat()).status.success());
    let report = desk.report();
    let causes = report["diagnosis"]["causes"].as_array().unwrap();
    let is_excluded = |c: &serde_json::Value| {
        c["label"] == "coulomb-friction"
            || (c["label"] == "input-delay" && c["site"]["name"] == "force")
    };
    assert!(!causes.iter().any(is_excluded));
    assert!(causes.iter().any(|c| c["label"] == "viscous-friction"));
    assert_eq!(report["inputs"]["outputs"][0]["noise"], 0.005);
    let refitted = report["diagnosis"]["best"]["nuisances"].as_array().unwrap();
    assert!(refitted.iter().all(|nuisance| nuisance["name"] != "d"));
    let settings = &report["settings"];
    assert_eq!((&settings["horizon"], &settings["window_s"]), (&"windows".into(), &2.0.into()));
    assert_eq!((&settings["seed"], &settings["split"]), (&7.into(), &0.67.into()));
    assert_eq!(settings["horizon_from"], "stated");
    let model = stdout(&desk.gap(&["--print-model", "--tolerance", "m=0.5"]));
    assert!(model.contains("m = { unit = \"kg\", value = 1.2, tolerance = 0.5 }"), "{model}");
}

/// A linear model has neither parameters with a meaning nor sites: it gets some.
#[test]
fn linear_models_are_diagnosed_as_well() {
    let desk = Desk::new();
    let head = "version = 1\nkind = \"state-space\"\nname = \"linear cart\"\n";
    let channels = "[[inputs]]\nname = \"force\"\nunit = \"N\"\n[[states]]\nname = \"v\"\nunit = \
                    \"m/s\"\n[[outputs]]\nname = \"speed\"\nunit = \"m/s\"\n[matrices]\n";
    let matrices = "A = [[-1.25]]\nB = [[0.8333]]\nC = [[1.0]]\n";
    desk.put("model.toml", &format!("{head}{channels}{matrices}"));
    let output = desk.gap(&["--held-out", "friday.csv"]);
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    assert_eq!(
        (&report["inputs"]["model"], &report["inputs"]["sample_time_s"]),
        (&"linear cart".into(), &0.01.into())
    );
    let names: Vec<&str> = report["diagnosis"]["best"]["nuisances"]
        .as_array()
        .unwrap()
        .iter()
        .map(|parameter| parameter["name"].as_str().unwrap())
        .collect();
    assert!(names.contains(&"time_scale") && names.contains(&"speed_gain"), "{names:?}");
    assert_eq!(report["diagnosis"]["groups"][0]["family"], "friction", "{}", report["headline"]);
    // A sampled model keeps its own pace.
    let matrices = "A = [[0.97531]]\nB = [[0.016461]]\nC = [[1.0]]\n";
    desk.put("model.toml", &format!("{head}sample_time = 0.02\n{channels}{matrices}"));
    assert!(desk.gap(&FEW).status.success());
    let inputs = desk.report()["inputs"].clone();
    assert_eq!((&inputs["sample_time_s"], &inputs["pace"]), (&0.02.into(), &"model".into()));
    assert!(desk.read("out/report.html").contains("pace of the model"));
    // A mistake in it is one of the file.
    desk.put(
        "model.toml",
        &format!("{head}{channels}{}", matrices.replace("[[1.0]]", "[[1.0, 2.0]]")),
    );
    fs::remove_dir_all(desk.path("out")).unwrap();
    refuses(&desk, &desk.gap(&FEW), 3, &["model.toml", "matrices.C"]);
}

/// One garbled number takes nothing but its row.
#[test]
fn a_single_wrong_sample_is_named_and_left_out() {
    let desk = Desk::new();
    desk.spoil("monday.csv", |row, cells| {
        if row == 437 {
            cells[2] = "99.0".to_owned();
        }
    });
    let output = desk.gap(&["--held-out", "friday.csv"]);
    assert!(output.status.success(), "{output:?}");
    assert!(stdout(&output).starts_with("Coulomb friction at rail ("), "{output:?}");
    let findings = desk.report()["findings"].clone();
    let wrong: Vec<_> = findings
        .as_array()
        .unwrap()
        .iter()
        .filter(|finding| finding["defect"]["kind"] == "wrong-sample")
        .collect();
    assert_eq!(wrong.len(), 1, "{findings}");
    assert_eq!(
        (&wrong[0]["defect"]["row"], &wrong[0]["defect"]["found"]),
        (&json!(437), &json!(99.0))
    );
}

/// A log cannot vouch for itself.
#[test]
fn a_held_out_log_that_was_fitted_is_found() {
    let desk = Desk::new();
    let output = desk.gap(&["--held-out", "monday.csv"]);
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    assert_eq!(report["findings"][0]["defect"]["kind"], "not-held-out", "{}", report["findings"]);
    assert_eq!(report["diagnosis"]["held_out"], json!([]));
    assert!(report["headline"].as_str().unwrap().contains("not checked on held-out data"));
}

/// A run that is cut in two begins its second part in motion.
#[test]
fn half_of_a_log_says_what_the_whole_one_does() {
    let desk = Desk::new();
    let text = desk.read("monday.csv");
    let lines = text.lines().filter(|line| !line.starts_with('#')).take(501);
    desk.put("half.csv", &lines.flat_map(|line| [line, "\n"]).collect::<String>());
    let output = desk.run(&["--model", "model.toml", "--log", "half.csv", "--out", "out"]);
    assert!(stdout(&output).starts_with("Coulomb friction at rail ("), "{output:?}");
    let closed = &desk.report()["diagnosis"]["held_out"][0]["closed_of_refit"]["interval"];
    assert!(0.8 < closed[1].as_f64().unwrap(), "{closed}");
}

/// Ctrl-C ends a study that would take minutes, with what there is.
#[test]
fn ctrl_c_ends_with_the_best_answer_so_far() {
    let desk = Desk::new();
    let long = ["--held-out", "friday.csv", "--calibrate", "10000"];
    let mut child = desk.command(&long).stdout(Stdio::null()).spawn().unwrap();
    // The folder is made when everything has been read that is asked for, and before the work begins.
    while !desk.path("out").exists() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert!(child.wait().unwrap().success());
    let report = desk.report();
    let left_out = report["stopped"].as_array().unwrap();
    assert!(left_out.contains(&json!("the self-calibration")), "{left_out:?}");
    let headline = report["headline"].as_str().unwrap();
    assert!(headline.starts_with("Stopped before the end; so far: "), "{headline}");
    assert!(desk.read("out/report.html").contains("It was stopped, and has not come to: "));
}

/// So does a time limit, also in the midst of a self-calibration that would take hours.
#[test]
fn a_time_limit_ends_with_the_best_answer_so_far() {
    let desk = Desk::new();
    let output = desk.gap(&["--calibrate", "10000", "--time-limit", "3s"]);
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    assert_eq!(report["time_limit"], json!(3.0));
    assert_eq!(report["calibration"], json!(null));
    let left_out = report["stopped"].as_array().unwrap();
    assert!(left_out.contains(&json!("the self-calibration")), "{left_out:?}");
    let headline = report["headline"].as_str().unwrap();
    assert!(headline.starts_with("Stopped by the time limit of 3 s; so far: "), "{headline}");
    assert!(desk.read("out/report.html").contains("It was stopped by its time limit of 3 s, and"));
}

/// The commonest silent mistake: a parameter that the simulator does not take.
#[test]
fn a_parameter_that_moves_nothing_is_named() {
    let desk = Desk::new();
    let spare = "[parameters]\nspare = { unit = \"N\", value = 2.0, tolerance = 0.1 }";
    let model = desk.read("model.toml").replace("[parameters]", spare);
    desk.put("model.toml", &model.replace("(force - d*v)/m", "(force - d*v + 0*spare)/m"));
    assert!(desk.gap(&FEW).status.success());
    let report = desk.report();
    assert_eq!(report["diagnosis"]["idle"], json!(["spare"]));
    let next = report["next"].as_array().unwrap();
    let says =
        |text: &serde_json::Value| text.as_str().unwrap().contains("`spare` moves no output");
    assert!(next.iter().any(says), "{next:?}");
}
