//! The live page behind nginx, as the example configuration has it.

use std::{
    fs,
    net::{TcpListener, TcpStream},
    path::Path,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use super::{asking, token};
use crate::watching::{Plant, text};

/// nginx with the example: its ports and files are those of the test.
struct Proxy {
    child: Child,
    port: u16,
    folder: std::path::PathBuf,
}

impl Proxy {
    fn start(plant: &Plant, monitor: &str) -> Self {
        let folder = plant.path("nginx");
        fs::create_dir(&folder).unwrap();
        let place = folder.display().to_string();
        let run = |line: &str| {
            let mut words = line.split(' ');
            let mut command = Command::new(words.next().unwrap());
            let output = command.args(words).current_dir(&folder).output().unwrap();
            assert!(output.status.success(), "{line}: {output:?}");
            text(&output.stdout)
        };
        run("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=plant.example \
             -addext subjectAltName=DNS:plant.example -keyout plant.example.key -out plant.example.crt");
        let word = run("openssl passwd -apr1 word");
        fs::write(folder.join("fdiag.users"), format!("ann:{word}")).unwrap();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/watch/nginx.conf");
        let mut site = fs::read_to_string(example).unwrap();
        for (from, to) in [
            ("listen 443 ssl", format!("listen 127.0.0.1:{port} ssl")),
            ("/etc/nginx", place.clone()),
            ("proxy_pass http://127.0.0.1:8080", format!("proxy_pass http://{monitor}")),
        ] {
            assert!(site.contains(from), "{from}");
            site = site.replace(from, &to);
        }
        let whole = format!(
            "daemon off; worker_processes 1; pid {place}/pid; error_log {place}/error.log;\n\
             events {{}}\nhttp {{ access_log off; client_body_temp_path {place}/body; \
             proxy_temp_path {place}/proxy; fastcgi_temp_path {place}/f; uwsgi_temp_path {place}/u; \
             scgi_temp_path {place}/s;\n{site}\n}}\n"
        );
        fs::write(folder.join("nginx.conf"), whole).unwrap();
        let program = ["/usr/sbin/nginx", "nginx"];
        let program = program.iter().find(|p| Path::new(p).exists()).unwrap_or(&"nginx");
        let child = Command::new(program)
            .arg("-c")
            .arg(folder.join("nginx.conf"))
            .arg("-p")
            .arg(&folder)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(begun.elapsed() < Duration::from_secs(10), "nginx does not answer");
            std::thread::sleep(Duration::from_millis(10));
        }
        Self { child, port, folder }
    }

    /// What curl gets from a path, status first.
    fn curl(&self, path: &str, more: &[&str]) -> (u16, String) {
        let output = Command::new("curl")
            .args(["-s", "--max-time", "5", "-w", "\n%{http_code}", "--cacert"])
            .arg(self.folder.join("plant.example.crt"))
            .args(["--resolve", &format!("plant.example:{}:127.0.0.1", self.port)])
            .args(more)
            .arg(format!("https://plant.example:{}{path}", self.port))
            .output()
            .unwrap();
        let all = text(&output.stdout);
        let (body, status) = all.rsplit_once('\n').unwrap();
        (status.parse().unwrap(), body.to_owned())
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        Command::new("kill").arg(self.child.id().to_string()).status().unwrap();
        self.child.wait().unwrap();
    }
}

#[test]
#[ignore = "needs nginx"]
fn through_nginx_whoever_has_a_password_looks_and_answers() {
    let plant = Plant::new();
    let (mut child, address, id) = asking(&plant, "--http-host plant.example");
    let proxy = Proxy::start(&plant, &address);
    let ann: [&str; 2] = ["-u", "ann:word"];

    assert_eq!(proxy.curl("/", &[]).0, 401);
    assert_eq!(proxy.curl("/answer", &["-d", "{}"]).0, 401);
    let (status, page) = proxy.curl("/", &ann);
    assert_eq!(status, 200);
    assert_eq!(proxy.curl("/metrics", &ann).0, 200);
    // Of the name that was asked for, the monitor judges.
    assert_eq!(proxy.curl("/", &[&ann[..], &["-H", "Host: evil.example"]].concat()).0, 421);
    // Events come as they are said: curl ends first.
    let (status, live) = proxy.curl("/live", &ann);
    assert_eq!(status, 200);
    assert!(live.contains("event: all") && live.contains("event: look"), "{live}");

    let origin = format!("Origin: https://plant.example:{}", proxy.port);
    let token = format!("X-Fdiag-Token: {}", token(&page));
    let said = format!("{{\"id\":\"{id}\",\"answer\":\"confirm\"}}");
    let answer = |origin: &str| {
        let fields = ["-H", origin, "-H", &token, "-H", "Content-Type: application/json"];
        proxy.curl("/answer", &[&ann[..], &fields, &["-d", &said]].concat())
    };
    assert_eq!(answer("Origin: https://plant.example").0, 403, "another port is another page");
    assert_eq!(answer("Origin: https://evil.example").0, 403);
    assert_eq!(answer(&origin), (200, "kept\n".to_owned()));
    drop(proxy);
    child.kill().unwrap();
    child.wait().unwrap();
}
