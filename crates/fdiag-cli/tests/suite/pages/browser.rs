//! A page in headless Chromium: what is clipped, empty, too faint, without a name or without life, and what its script
//! complains of.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Duration,
};

use serde_json::Value;
use tempfile::TempDir;

use crate::pages::between::serve;

/// Widths of a desk and of a telephone, in pixels.
const WIDTHS: [u32; 2] = [1280, 390];
/// Time that a page has to draw itself.
const DRAWN: Duration = Duration::from_millis(2500);

pub(crate) struct Browser {
    folder: TempDir,
    program: PathBuf,
    /// Of what stands between it and pages.
    port: u16,
}

/// Where the browser is.
pub(crate) fn chromium() -> PathBuf {
    let names = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
    let program = names.iter().map(PathBuf::from).find(|path| path.exists());
    program.unwrap_or_else(|| panic!("this test needs chromium: none of {names:?}"))
}

impl Browser {
    pub(crate) fn new() -> Self {
        Self::beside(None)
    }

    /// One that can look at the live page of a monitor.
    #[track_caller]
    pub(crate) fn live_is_in_order(name: &str, address: &str, pictures: u64) {
        let browser = Self::beside(Some(address.to_owned()));
        browser.is_in_order(name, &format!("http://127.0.0.1:{}/", browser.port), pictures);
    }

    fn beside(live: Option<String>) -> Self {
        let program = chromium();
        let folder = tempfile::tempdir().unwrap();
        let port = serve(live, &folder.path().join("desk.html"), DRAWN);
        Self { folder, program, port }
    }

    /// Looks at a page, on a desk and on a telephone, in the light and in the dark. It has this many pictures at least.
    #[track_caller]
    pub(crate) fn is_in_order(&self, name: &str, address: &str, pictures: u64) {
        for width in WIDTHS {
            for is_dark in [false, true] {
                let found = self.look(address, width, is_dark);
                let place =
                    format!("{name}, {width} px, {}", if is_dark { "dark" } else { "light" });
                println!("{place}: {found}");
                assert_eq!(found["width"], width, "{place}");
                assert_eq!(found["dark"], is_dark, "{place}");
                assert!(pictures <= found["pictures"].as_u64().unwrap(), "{place}: {found}");
                assert!(100 < found["words"].as_u64().unwrap(), "{place}: {found}");
                for list in ["clipped", "empty", "faint", "nameless", "dead", "complaints"] {
                    assert_eq!(found[list], serde_json::json!([]), "{place}: {list}");
                }
            }
        }
    }

    /// The same of a file.
    #[track_caller]
    pub(crate) fn file_is_in_order(&self, name: &str, file: &Path, pictures: u64) {
        let file = file.canonicalize().unwrap();
        self.is_in_order(name, &format!("file://{}", file.display()), pictures);
    }

    /// What is found of a page in a frame of so many pixels: a window is never as narrow as a telephone.
    pub(crate) fn look(&self, address: &str, width: u32, is_dark: bool) -> Value {
        let script = include_str!("look.js");
        let desk = format!(
            "<!doctype html><meta charset=\"utf-8\"><title>desk</title>\
             <iframe id=\"frame\" style=\"width:{width}px;height:900px;border:0\" src=\"{address}\"></iframe>\
             <img hidden src=\"http://127.0.0.1:{}/late\"><pre id=\"found\"></pre><script>{script}\n\
             setTimeout(() => {{ document.getElementById(\"found\").textContent = \
             JSON.stringify(look(document.getElementById(\"frame\"))); }}, {});</script>",
            self.port,
            DRAWN.as_millis() - 500
        );
        let file = self.folder.path().join("desk.html");
        fs::write(&file, desk).unwrap();
        let desk = match address.strip_prefix("http") {
            Some(_) => format!("http://127.0.0.1:{}/desk.html", self.port),
            None => format!("file://{}", file.display()),
        };
        let profile = self.folder.path().join("profile");
        let output = Command::new(&self.program)
            // The desk has to look into the frame, and there may be no sandbox where tests run.
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-web-security"])
            .args(["--disable-site-isolation-trials", "--allow-file-access-from-files"])
            .arg("--disable-features=LocalNetworkAccessChecks")
            .args(["--enable-logging=stderr", "--dump-dom", "--window-size=1400,1000"])
            .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!is_dark)))
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg(desk)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let dom = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        let text =
            dom.split("<pre id=\"found\">").nth(1).and_then(|rest| rest.split("</pre>").next());
        let text = text.unwrap_or_else(|| panic!("chromium shows nothing of {address}: {errors}"));
        let plain = text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
        let mut found: Value = serde_json::from_str(&plain)
            .unwrap_or_else(|error| panic!("{address}: {error}: {plain:?}: {errors}"));
        let complaints: Vec<&str> =
            errors.lines().filter(|line| line.contains("CONSOLE")).collect();
        found["complaints"] = complaints.into();
        found
    }
}
