//! The clients for C and C++: installed into a folder of the tests' own, and programs built against them as their users build them, with every
//! compiler that is there. Which compilers, valgrind and CMake are missing is said.

use sinew_ipc::Mode;
use sinew_tests::page::{Block, blocks};
use sinew_tests::{Driver, PATIENCE, Process, Rig, SENSING_DUTY, c_libraries, checkout, entries, wait_for, wait_until};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::clients::{hexapod, walks_and_lets_go};

const C: &[&str] = &["-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
pub const CPP: &[&str] = &["-std=c++17", "-O1", "-g", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
/// Besides: what the sanitizers find ends the program.
pub const SANITIZED: &[&str] =
    &["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];

/// Where the client is installed for these tests.
pub fn prefix() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        // Those of earlier runs are nobody's.
        for name in entries(folder) {
            let pid = name.strip_prefix("c-").filter(|pid| !Path::new("/proc").join(pid).exists());
            pid.map(|_| fs::remove_dir_all(folder.join(&name)));
        }
        let prefix = folder.join(format!("c-{}", std::process::id()));
        let mut install = Command::new(checkout().join("bindings/c/install.sh"));
        let said = Process::start(install.arg(&prefix).arg(c_libraries())).finish().expect(0).stdout;
        assert!(said.contains("installed sinew"), "{said}");
        prefix
    })
}

/// Whether this program is there; said where it is not.
pub fn is_there(program: &str) -> bool {
    let found = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !found {
        println!("skipped for want of {program}");
    }
    found
}

/// The compilers of a language that are there. One at least is needed: cargo links with it.
pub fn compilers(candidates: [&'static str; 2]) -> Vec<&'static str> {
    let found: Vec<&str> = candidates.into_iter().filter(|compiler| is_there(compiler)).collect();
    assert!(!found.is_empty(), "none of {candidates:?}");
    found
}

/// Those of them that come with sanitizers.
pub fn sanitizing(candidates: [&'static str; 2]) -> Vec<&'static str> {
    let empty = prefix().join("empty.c");
    fs::write(&empty, "int main(void) { return 0; }\n").expect("a writable folder");
    let can = |compiler: &&str| {
        let language = if compiler.ends_with("++") { "c++" } else { "c" };
        let mut compile = Command::new(compiler);
        compile.args(SANITIZED).args(["-x", language]).arg(&empty).arg("-o").arg(prefix().join("empty"));
        let can = compile.output().is_ok_and(|said| said.status.success());
        if !can {
            println!("skipped for want of the sanitizers of {compiler}");
        }
        can
    };
    compilers(candidates).into_iter().filter(can).collect()
}

/// Runs a command that has to succeed; what it said on stdout.
#[track_caller]
pub fn succeeds(command: &mut Command) -> String {
    let said = command.stdin(Stdio::null()).output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let (out, err) = (String::from_utf8_lossy(&said.stdout), String::from_utf8_lossy(&said.stderr));
    assert!(said.status.success(), "{command:?}:\n{out}{err}");
    out.into()
}

/// What `pkg-config` says for the installed client.
fn pkg_config(words: &[&str]) -> Vec<String> {
    let mut ask = Command::new("pkg-config");
    let said = succeeds(ask.args(words).arg("sinew").env("PKG_CONFIG_PATH", prefix().join("lib/pkgconfig")));
    said.split_whitespace().map(String::from).collect()
}

/// A program built from this source, against the shared library; where it lies.
#[track_caller]
fn built(compiler: &str, flags: &[&str], source: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let program = prefix().join(format!("program-{}", COUNT.fetch_add(1, Ordering::Relaxed)));
    let mut compile = Command::new(compiler);
    compile.args(flags).arg(source).arg("-o").arg(&program);
    succeeds(against_the_client(&mut compile));
    program
}

/// A compiler's command, told where the shared library and its headers are.
pub fn against_the_client(compile: &mut Command) -> &mut Command {
    compile.arg("-I").arg(prefix().join("include"));
    compile.arg("-L").arg(prefix().join("lib")).args(["-lsinew", "-lm", "-lpthread"]);
    compile.arg(format!("-Wl,-rpath,{}", prefix().join("lib").display()))
}

pub fn source(path: &str) -> PathBuf {
    checkout().join("bindings").join(path)
}

/// A program of these tests, started for a rig.
pub fn program(path: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(path);
    command.args(arguments);
    // An error ends it with a code of its own, so that it is not taken for the program's.
    command.env("UBSAN_OPTIONS", "print_stacktrace=1").env("ASAN_OPTIONS", "exitcode=99:detect_leaks=1");
    command
}

/// Runs a program on a bench of two wires of its own.
#[track_caller]
fn run_on_a_bench<T>(run: impl FnOnce(&Rig) -> T) -> T {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, observer) = Driver::ready(&rig);
    let finished = run(&rig);
    if observer.is_alive() {
        driver.stop();
    } else {
        driver.stopped();
    }
    finished
}

/// The robot programs that are shown to people, with the sanitizers where there are any.
#[test]
fn the_c_robot_walks_the_hexapod_and_lets_go() {
    let sanitized = sanitizing(["gcc", "clang"]);
    for compiler in compilers(["gcc", "clang"]) {
        let more: &[&str] = if sanitized.contains(&compiler) { SANITIZED } else { &[] };
        let robot = built(compiler, &[C, more].concat(), &source("c/examples/gait.c"));
        walks_and_lets_go(|rig| program(&robot, &[&rig.name]));
    }
}

#[test]
fn the_cpp_robot_walks_the_hexapod_and_lets_go() {
    let sanitized = sanitizing(["g++", "clang++"]);
    for compiler in compilers(["g++", "clang++"]) {
        let more: &[&str] = if sanitized.contains(&compiler) { SANITIZED } else { &[] };
        let robot = built(compiler, &[CPP, more].concat(), &source("cpp/examples/gait.cpp"));
        walks_and_lets_go(|rig| program(&robot, &[&rig.name]));
    }
}

/// Built with the sanitizers, and with each compiler: every call as it is meant.
#[test]
fn every_call_of_c_does_what_it_says() {
    for compiler in sanitizing(["gcc", "clang"]) {
        let flags = [C, SANITIZED].concat();
        let tour = built(compiler, &flags, &source("c/tests/programs/tour.c"));
        let said = run_on_a_bench(|rig| Process::start(&mut program(&tour, &[&rig.name])).finish()).expect(0);
        assert_eq!((said.stdout.as_str(), said.stderr.as_str()), ("seen all\n", ""), "{compiler}");
    }
}

#[test]
fn every_call_of_cpp_does_what_it_says() {
    for compiler in sanitizing(["g++", "clang++"]) {
        let flags = [CPP, SANITIZED].concat();
        let tour = built(compiler, &flags, &source("cpp/tests/programs/tour.cpp"));
        let said = run_on_a_bench(|rig| Process::start(&mut program(&tour, &[&rig.name])).finish()).expect(0);
        assert_eq!((said.stdout.as_str(), said.stderr.as_str()), ("seen all\n", ""), "{compiler}");
    }
}

/// Each mistake has its error and remedy; the driver goes on, and nothing but the sensing pulse has reached the wires.
#[test]
fn what_is_done_wrong_in_c_is_refused_with_a_remedy() {
    for compiler in sanitizing(["gcc", "clang"]) {
        let flags = [C, SANITIZED].concat();
        let misuse = built(compiler, &flags, &source("c/tests/programs/misuse.c"));
        let said = run_on_a_bench(|rig| {
            let observer = rig.client();
            let mut stream = observer.stream().unwrap();
            let mut process = Process::start(&mut program(&misuse, &[&rig.name]));
            wait_until("the program to have done everything wrong", || {
                while let Some(cycle) = stream.next().unwrap() {
                    assert!(cycle.channels.iter().all(|channel| channel.duty <= SENSING_DUTY), "{cycle:?}");
                }
                process.ended().is_some()
            });
            assert!(observer.is_alive());
            process.finish()
        });
        let said = said.expect(0);
        assert_eq!((said.stdout.as_str(), said.stderr.as_str()), ("refused all\n", ""), "{compiler}");
    }
}

/// Programs of robots have timers: their signals interrupt system calls, which Rust's own programs have begun anew for them.
#[test]
fn signals_disturb_no_call_of_c() {
    let signals = built(compilers(["gcc", "clang"])[0], C, &source("c/tests/programs/signals.c"));
    let said = run_on_a_bench(|rig| Process::start(&mut program(&signals, &[&rig.name])).finish()).expect(0);
    assert_eq!((said.stdout.as_str(), said.stderr.as_str()), ("not disturbed\n", ""));
}

/// Runs a program under valgrind, which has to find nothing. What is reachable to the end is not lost: texts of faults and the like are
/// made once and stay.
#[track_caller]
fn clean_under_valgrind(program: &Path, arguments: &[&str]) -> String {
    let kinds = "definite,indirect,possible";
    let mut command = Command::new("valgrind");
    command.args(["--quiet", "--leak-check=full", "--error-exitcode=99", "--fair-sched=yes"]);
    command.args(["errors-for-leak", "show-leak"].map(|what| format!("--{what}-kinds={kinds}")));
    let said = Process::start(command.arg(program).args(arguments)).finish().expect(0);
    assert_eq!(said.stderr, "", "{}", program.display());
    said.stdout
}

/// Nothing is lost and nothing is read that was never written, on the side of Rust either.
#[test]
fn valgrind_finds_neither_leaks_nor_errors() {
    if !is_there("valgrind") {
        return;
    }
    let (c, cpp) = (compilers(["gcc", "clang"])[0], compilers(["g++", "clang++"])[0]);
    let programs = [
        ("c/tests/programs/tour.c", c, C),
        ("c/tests/programs/misuse.c", c, C),
        ("cpp/tests/programs/tour.cpp", cpp, CPP),
    ];
    for (path, compiler, flags) in programs {
        let built = built(compiler, flags, &source(path));
        run_on_a_bench(|rig| clean_under_valgrind(&built, &[&rig.name]));
    }
    let rig = hexapod();
    let (driver, _) = Driver::ready(&rig);
    for (path, compiler, flags) in [("c/examples/gait.c", c, C), ("cpp/examples/gait.cpp", cpp, CPP)] {
        let said = clean_under_valgrind(&built(compiler, flags, &source(path)), &[&rig.name, "4"]);
        assert!(said.contains("rms error") && said.ends_with("all channels off\n"), "{said}");
    }
    driver.stop();
}

/// Killed in the middle of a command, at another time each: its lease ends, and the wire gets the sensing pulse and no more. The others go on.
#[test]
fn a_c_program_that_is_killed_leaves_no_wire_heated() {
    let hold = built(compilers(["gcc", "clang"])[0], C, &source("c/tests/programs/hold.c"));
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, observer) = Driver::ready(&rig);
    observer.set_duty("right", 0.1, PATIENCE).unwrap();
    for round in 0..6 {
        let mut holder = Process::start(&mut program(&hold, &[&rig.name, "left", "0.3", "1.5"]));
        holder.wait_for_word("holding");
        wait_until("the wire to be heated", || observer.latest().channels()[0].duty > 2.0 * SENSING_DUTY);
        std::thread::sleep(Duration::from_micros(round * 617));
        holder.kill();
        let left = wait_for("the lease to run out", || {
            let left = observer.latest().channels()[0];
            (left.mode() != Mode::Length).then_some(left)
        });
        assert_eq!((left.mode(), left.fault()), (Mode::Lapsed, None), "round {round}: {left:?}");
        assert_eq!(left.duty, SENSING_DUTY, "round {round}");
        let right = observer.latest().channels()[1];
        assert_eq!((right.mode(), right.duty), (Mode::Duty, 0.1), "round {round}");
        // It cools: what is published is what the wire gets.
        let hot_c = left.temperature_c;
        wait_until("the wire to cool", || observer.latest().channels()[0].temperature_c < hot_c - 5.0);
    }
    let report = driver.stop();
    // One each; one more where the machine kept a holder from renewing for as long as its lease.
    assert!(report["leases_lapsed"].as_u64() >= Some(6), "{report:#}");
}

/// The words a program is compiled with, as pkg-config and CMake give them, for the shared and for the static library.
#[test]
fn pkg_config_and_cmake_lead_to_the_installed_client() {
    let tour = source("c/tests/programs/tour.c");
    let library_path = prefix().join("lib");
    let mut programs = Vec::new();

    if is_there("pkg-config") {
        let compiler = compilers(["gcc", "clang"])[0];
        for (name, words, which) in [
            ("pkg-shared", &["--cflags", "--libs"][..], &[][..]),
            ("pkg-static", &["--cflags", "--libs", "--static"][..], &["-Wl,-Bstatic", "-lsinew", "-Wl,-Bdynamic"][..]),
        ] {
            let program = prefix().join(name);
            let mut compile = Command::new(compiler);
            let said = pkg_config(words).into_iter().flat_map(|word| match (word.as_str(), which) {
                ("-lsinew", [_, ..]) => which.iter().map(|word| word.to_string()).collect(),
                _ => vec![word],
            });
            compile.args(C).arg(&tour).arg("-o").arg(&program).args(said).arg("-lm");
            succeeds(&mut compile);
            programs.push(program);
        }
        assert_eq!(pkg_config(&["--modversion"]), [env!("CARGO_PKG_VERSION")]);
    }

    if is_there("cmake") {
        let project = prefix().join("project");
        fs::create_dir_all(&project).unwrap();
        let text = format!(
            "cmake_minimum_required(VERSION 3.16)\nproject(robot C CXX)\nset(CMAKE_CXX_STANDARD 17)\nset(CMAKE_C_STANDARD 11)\n\
             find_package(sinew {} REQUIRED)\n\
             add_executable(shared {tour})\ntarget_link_libraries(shared sinew::sinew m)\n\
             add_executable(static {tour})\ntarget_link_libraries(static sinew::static)\n\
             add_executable(cpp {})\ntarget_link_libraries(cpp sinew::sinew)\n",
            env!("CARGO_PKG_VERSION"),
            source("cpp/tests/programs/tour.cpp").display(),
            tour = tour.display(),
        );
        fs::write(project.join("CMakeLists.txt"), text).unwrap();
        let prefix_path = format!("-DCMAKE_PREFIX_PATH={}", prefix().display());
        let build = project.join("build");
        succeeds(Command::new("cmake").arg("-S").arg(&project).arg("-B").arg(&build).arg(prefix_path));
        succeeds(Command::new("cmake").arg("--build").arg(&build));
        programs.extend(["shared", "static", "cpp"].map(|name| build.join(name)));
        // A version that is not there is not found.
        let other = fs::read_to_string(project.join("CMakeLists.txt")).unwrap();
        let other = other.replace(&format!("sinew {} ", env!("CARGO_PKG_VERSION")), "sinew 99.0 ");
        fs::write(project.join("CMakeLists.txt"), other).unwrap();
        let refused = Command::new("cmake").arg("-S").arg(&project).arg("-B").arg(&build).output().unwrap();
        assert!(!refused.status.success());
    }

    for path in programs {
        let is_static = path.ends_with("pkg-static") || path.ends_with("static");
        let needed = fs::read(&path).unwrap();
        let names_the_library = needed.windows(b"libsinew.so.".len()).any(|bytes| bytes == b"libsinew.so.");
        assert_eq!(names_the_library, !is_static, "{}", path.display());
        let said = run_on_a_bench(|rig| {
            let mut command = program(&path, &[&rig.name]);
            if !is_static {
                command.env("LD_LIBRARY_PATH", &library_path);
            }
            Process::start(&mut command).finish()
        });
        assert_eq!(said.expect(0).stdout, "seen all\n", "{}", path.display());
    }
}

/// The first lines a newcomer types, from the page: at most ten, without a warning, and the wire of the built-in hexapod moves.
#[test]
fn the_quick_starts_of_the_page_run_as_printed() {
    let folder = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(checkout().join("docs/bindings.md")).expect("it is in the checkout");
    let rig = Rig::named(|_| fs::read_to_string(checkout().join("examples/hexapod.toml")).unwrap());
    let own = |command: &mut Command| {
        command.env("SINEW_RUNTIME_DIR", folder.path()).env("LD_LIBRARY_PATH", prefix().join("lib"));
    };
    let mut command = rig.command(&["--for", "300"]);
    own(&mut command);
    let driver = Process::start(&mut command);
    for (language, flags, compilers) in
        [("c", C, compilers(["gcc", "clang"])), ("cpp", CPP, compilers(["g++", "clang++"]))]
    {
        let is_start = |block: &Block| block.language == language && block.text.contains("main(");
        let text = blocks(&page).into_iter().find(is_start).expect("a quick start").text;
        assert!(text.lines().count() <= 10, "{text}");
        for compiler in compilers {
            let file = folder.path().join(format!("start.{language}"));
            fs::write(&file, &text).unwrap();
            let start = built(compiler, flags, &file);
            // At first no driver is there yet, or its sensors have not proved themselves: the program says so. And in a cycle that a busy machine
            // missed nothing was measured: it prints the NaN that the page has for it.
            let said = wait_for("the quick start to run", || {
                let mut command = Command::new(&start);
                own(&mut command);
                let said = Process::start(&mut command).finish();
                match said.code {
                    Some(0) => (said.stdout != "nan mm\n").then_some(said),
                    _ => {
                        assert!(said.stderr.contains("; "), "an error ends with its remedy: {said:?}");
                        None
                    }
                }
            });
            let length_mm: f64 =
                said.stdout.trim().trim_end_matches(" mm").parse().unwrap_or_else(|_| panic!("{said:?}"));
            assert!((150.0..170.0).contains(&length_mm), "{said:?}");
        }
    }
    driver.signal(libc::SIGTERM);
    driver.finish().expect(0);
}
