//! Data on standard output, everything else on standard error; quiet, colours, threads, limits.

use graticule_fixtures::bumpy_patch;

use crate::bench::Bench;

#[test]
fn a_mesh_on_standard_output_is_alone_there() {
    let bench = Bench::with(&bumpy_patch(4, 1));
    let run = bench.succeed("flatten patch.obj -o - --format obj");
    let words: Vec<&str> = run
        .stdout
        .lines()
        .filter_map(|l| l.split(' ').next())
        .collect();
    assert!(
        words
            .iter()
            .all(|word| ["v", "vt", "f", "#"].contains(word)),
        "{words:?}"
    );
    assert!(run.stderr.contains("quasi-conformal"));
    bench.write("again.obj", &run.stdout);
    bench.succeed("measure again.obj");
}

#[test]
fn the_report_on_standard_output_is_alone_there() {
    let bench = Bench::with(&bumpy_patch(4, 1));
    for words in [
        "info patch.obj --json",
        "repair patch.obj -o a.obj --json",
        "flatten patch.obj -o b.obj --json",
        "measure b.obj --json",
        "cite --json",
        "demo --rings 30 --json",
    ] {
        let run = bench.succeed(words);
        let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        let keys: Vec<&String> = report.as_object().unwrap().keys().collect();
        let expected = [
            "graticule",
            "command",
            "error",
            "input",
            "options",
            "repair",
            "result",
            "measure",
            "warnings",
            "times",
            "processor_seconds",
            "peak_memory_bytes",
        ];
        assert_eq!(keys, expected, "{words}");
        assert_eq!(report["command"], words.split(' ').next().unwrap());
    }
}

#[test]
fn quiet_is_quiet_but_for_errors() {
    let bench = Bench::with(&bumpy_patch(4, 1));
    for words in [
        "repair patch.obj -o a.obj --quiet",
        "flatten patch.obj -o b.obj --quiet --picture b.png --report b.json",
    ] {
        let run = bench.succeed(words);
        assert_eq!(
            (run.stdout, run.stderr),
            (String::new(), String::new()),
            "{words}"
        );
    }
    assert_eq!(bench.succeed("measure b.obj --quiet").stderr, "");
    bench.refuse(1, "info missing.obj --quiet");
}

#[test]
fn a_failure_is_told_in_plain_letters_where_there_is_no_terminal() {
    let bench = Bench::new();
    let output = bench
        .command()
        .args(["info", "missing.obj"])
        .output()
        .unwrap();
    assert!(!output.stderr.contains(&0x1b));
    let no_color = bench
        .command()
        .args(["info", "missing.obj"])
        .env("NO_COLOR", "1")
        .output();
    // Times differ from run to run.
    let without_times = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let lines = text.lines().filter(|line| !line.starts_with('['));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        without_times(&no_color.unwrap().stderr),
        without_times(&output.stderr)
    );
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let bench = Bench::with(&bumpy_patch(40, 3));
    for threads in [1, 2] {
        bench.succeed(&format!(
            "flatten patch.obj -o t{threads}.ply --threads {threads} --picture t{threads}.png"
        ));
    }
    for extension in ["ply", "png"] {
        let bytes =
            |threads| std::fs::read(bench.path(&format!("t{threads}.{extension}"))).unwrap();
        assert_eq!(bytes(1), bytes(2), "{extension}");
    }
}

#[test]
fn a_time_limit_that_is_too_short_is_told_and_leaves_nothing() {
    let bench = Bench::with(&bumpy_patch(60, 1));
    let fact = bench.refuse(1, "flatten patch.obj -o out.obj --max-seconds 0.000001");
    assert!(fact.contains("time limit"), "{fact}");
}

#[test]
fn a_failure_is_reported_too() {
    let bench = Bench::new();
    bench.write("cube.obj", &graticule_fixtures::cube().to_obj());
    let run = bench.run("flatten cube.obj -o out.obj --report report.json --json");
    assert_eq!(run.code, 1);
    assert_eq!(run.stdout, bench.read("report.json"));
    let report = bench.json("report.json");
    let fact = report["error"]["fact"].as_str().unwrap();
    assert!(run.stderr.contains(fact), "{fact}");
    assert_eq!(report["command"], "flatten");
    assert_eq!(report["options"]["method"], "natural");
    assert!(report["result"].is_null());
    assert_eq!(bench.files(), ["cube.obj", "report.json"]);
    bench.refuse(2, "flatten cube.obj -o out.xyz --report none.json");
}

#[test]
fn a_mesh_is_read_from_standard_input() {
    let bench = Bench::new();
    let run = |words: &str, text: &str| {
        let words = words.split(' ');
        let run = bench.command().args(words).write_stdin(text).output();
        let run = run.unwrap();
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        String::from_utf8(run.stdout).unwrap()
    };
    let text = bumpy_patch(3, 1).to_obj();
    let flat = run("flatten - -o - --format obj --quiet", &text);
    assert!(flat.contains("\nvt "));
    assert!(run("measure -", &flat).contains("one to one"));
    assert!(run("info -", &flat).starts_with("<stdin>\n"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_command_started_by_nohup_outlives_its_terminal() {
    let bench = Bench::with(&bumpy_patch(150, 1));
    let program = assert_cmd::cargo::cargo_bin!("graticule");
    let script = format!(
        "trap '' HUP; {} flatten patch.obj -o out.obj --quiet & \
         for i in 1 2 3 4 5 6 7 8; do kill -HUP $! 2>/dev/null; sleep 0.05; done; wait $!",
        program.display()
    );
    let shell = std::process::Command::new("sh")
        .args(["-c", &script])
        .current_dir(bench.path(""))
        .status();
    assert_eq!(shell.unwrap().code(), Some(0));
    assert_eq!(bench.files(), ["out.obj", "patch.obj"]);
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let bench = Bench::with(&bumpy_patch(30, 1));
    let program = assert_cmd::cargo::cargo_bin!("graticule");
    let script = format!(
        "{} flatten patch.obj -o - --format obj --quiet | head -n 1; exit ${{PIPESTATUS[0]}}",
        program.display()
    );
    let output = assert_cmd::Command::new("bash")
        .args(["-c", &script])
        .current_dir(bench.path(""))
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

#[cfg(unix)]
#[test]
fn a_request_to_end_ends_the_command_and_leaves_nothing() {
    let bench = Bench::with(&bumpy_patch(300, 1));
    let program = assert_cmd::cargo::cargo_bin!("graticule");
    let mut child = std::process::Command::new(program)
        .args([
            "flatten",
            "patch.obj",
            "-o",
            "out.obj",
            "--report",
            "out.json",
        ])
        .current_dir(bench.path(""))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // In the midst of its work, however busy the machine is.
    let stderr = std::io::BufReader::new(child.stderr.take().unwrap());
    let mut lines = std::io::BufRead::lines(stderr).map(Result::unwrap);
    assert!(lines.any(|line| line.ends_with("repair")));
    let kill = std::process::Command::new("sh")
        .args(["-c", &format!("kill -TERM {}", child.id())])
        .status();
    assert!(kill.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert_eq!(bench.files(), ["patch.obj"]);
}
