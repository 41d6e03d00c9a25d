//! The hardware component for ros2_control, under a program that does with it what the controller manager does. It is built against a stub of
//! ROS 2's headers, with every compiler that is there, and runs against running drivers.

use crate::bindings_c::{CPP, SANITIZED, against_the_client, compilers, prefix, program, sanitizing, source, succeeds};
use crate::clients::hexapod;
use sinew_ipc::{Client, Mode};
use sinew_physics::Load;
use sinew_rig::Rig as RigFile;
use sinew_tests::page::{Block, blocks};
use sinew_tests::{Driver, Finished, Process, Rig, SENSING_DUTY, checkout, wait_for, wait_until};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

const CPP_COMPILERS: [&str; 2] = ["g++", "clang++"];

/// The component and the program that drives it, as one compiler makes them.
#[derive(Clone)]
struct Built {
    library: PathBuf,
    drive: PathBuf,
}

impl Built {
    /// The program for a task on a rig.
    fn task(&self, task: &str, rig: &Rig, more: &str) -> Command {
        let library = self.library.to_str().expect("the path is text");
        program(&self.drive, &[library, task, &rig.name, more])
    }
}

/// Whether a compiler finds a header; said where it does not.
fn has_header(compiler: &str, header: &str, package: &str) -> bool {
    let probe = ["-x", "c++", "-E", "-include", header, "/dev/null"];
    let found = Command::new(compiler).args(probe).output().is_ok_and(|said| said.status.success());
    if !found {
        println!("skipped for want of {header} (Debian: {package})");
    }
    found
}

/// Builds both against these headers of ROS 2.
#[track_caller]
fn built_on(compiler: &str, more: &[&str], headers: &[PathBuf], libraries: &[&str]) -> Built {
    let folder =
        tempfile::Builder::new().prefix("ros2_control-").tempdir_in(prefix()).expect("a writable folder").keep();
    let package = source("ros2_control");
    let compile = |what: &[&str], to: &PathBuf| {
        let mut compile = Command::new(compiler);
        compile.args(CPP).args(more).arg("-I").arg(package.join("include"));
        for headers in headers {
            compile.arg("-isystem").arg(headers);
        }
        compile.args(what.iter().map(|word| match word.ends_with(".cpp") {
            true => package.join(word),
            false => word.into(),
        }));
        succeeds(against_the_client(&mut compile).args(libraries).arg("-o").arg(to));
    };
    let built = Built { library: folder.join("libsinew_ros2_control.so"), drive: folder.join("drive") };
    let sources = ["src/joint.cpp", "src/parameters.cpp", "src/sender.cpp", "src/system.cpp"];
    compile(&[&["-fPIC", "-shared"][..], &sources[..]].concat(), &built.library);
    compile(&["tests/programs/drive.cpp", "-ldl"], &built.drive);
    built
}

/// Both, built against the stub; once for all tests. Or it is said why not: the URDF is read by a library that may be missing.
#[track_caller]
fn built(compiler: &'static str, more: &[&'static str]) -> Option<Built> {
    static BUILT: Mutex<BTreeMap<(&str, bool), Built>> = Mutex::new(BTreeMap::new());
    if !has_header(compiler, "tinyxml2.h", "libtinyxml2-dev") {
        return None;
    }
    let mut built = BUILT.lock().unwrap_or_else(PoisonError::into_inner);
    let stub = source("ros2_control/tests/stub");
    let make = || built_on(compiler, more, &[stub], &["-ltinyxml2"]);
    Some(built.entry((compiler, more.is_empty())).or_insert_with(make).clone())
}

/// What the component is made of is all that lies there, and what `CMakeLists.txt` builds.
#[test]
fn every_source_is_built_and_every_name_is_that_of_the_class() {
    let package = source("ros2_control");
    let read = |name: &str| fs::read_to_string(package.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (cmake, plugin, manifest) = (read("CMakeLists.txt"), read("sinew_ros2_control.xml"), read("package.xml"));
    for entry in sinew_tests::entries(&package.join("src")).iter().filter(|name| name.ends_with(".cpp")) {
        assert!(cmake.contains(&format!("  src/{entry}\n")), "{entry}");
    }
    // pluginlib finds the class by what the library registers, and the URDF names what the plugin's file does.
    assert!(plugin.contains(r#"<library path="sinew_ros2_control">"#), "{plugin}");
    assert!(
        plugin.contains(r#"<class name="sinew_ros2_control/System" type="sinew_ros2_control::System""#),
        "{plugin}"
    );
    let exported = "PLUGINLIB_EXPORT_CLASS(sinew_ros2_control::System, hardware_interface::SystemInterface)";
    assert!(read("src/system.cpp").contains(exported));
    assert!(read("urdf/hexapod.urdf").contains("<plugin>sinew_ros2_control/System</plugin>"));
    assert!(cmake.contains("project(sinew_ros2_control ") && manifest.contains("<name>sinew_ros2_control</name>"));
    assert!(manifest.contains(&format!("<version>{}</version>", env!("CARGO_PKG_VERSION"))), "{manifest}");
    let minor = env!("CARGO_PKG_VERSION").rsplit_once('.').expect("it has dots").0;
    assert!(cmake.contains(&format!("find_package(sinew {minor} REQUIRED)")), "{cmake}");
}

/// URDF and controllers name the channels of the built-in hexapod, each once, with the springs of its rig file.
#[test]
fn the_urdf_and_the_controllers_are_those_of_the_hexapod() {
    let package = source("ros2_control");
    let rig = RigFile::load(&checkout().join("examples/hexapod.toml")).unwrap();
    let urdf = fs::read_to_string(package.join("urdf/hexapod.urdf")).unwrap();
    let controllers = fs::read_to_string(package.join("config/hexapod.yaml")).unwrap();
    let listed: Vec<&str> = controllers
        .lines()
        .filter_map(|line| line.strip_prefix("      - "))
        .filter(|name| name.contains('_'))
        .collect();
    assert_eq!(rig.channels.len(), 18);
    for channel in &rig.channels {
        let name = &channel.name;
        assert_eq!(listed.iter().filter(|joint| *joint == name).count(), 1, "{name}");
        assert!(urdf.contains(&format!("<joint name=\"{name}\" type=\"revolute\">")), "{name}");
        let joint = urdf.split_once(&format!("    <joint name=\"{name}\">\n")).unwrap_or_else(|| panic!("{name}")).1;
        let joint = joint.split_once("</joint>").unwrap().0;
        let Load::SpringMassDamper { spring_n_per_m, preload_n, .. } = channel.model.load else {
            panic!("{name} has another load")
        };
        for (key, meant) in [("spring_n_per_m", spring_n_per_m), ("preload_n", preload_n)] {
            let said = joint.split_once(&format!("<param name=\"{key}\">")).unwrap().1.split_once('<').unwrap().0;
            assert_eq!(said.parse(), Ok(meant), "{name} {key}");
        }
    }
    assert_eq!(listed.len(), 18);
    // No lever lets a wire be asked for more than it has.
    let rig = hexapod();
    let (driver, client) = Driver::ready(&rig);
    for channel in client.channels() {
        let link = urdf.split_once(&format!("<joint name=\"{}\" type=\"revolute\">", channel.name)).unwrap().1;
        let upper: f64 = link.split_once("upper=\"").unwrap().1.split_once('"').unwrap().0.parse().unwrap();
        assert!(upper * 8e-3 <= channel.cold_length_m - channel.min_length_m, "{}", channel.name);
    }
    driver.stop();
}

/// Eighteen joints at 100 Hz: each goes where it is told, without an allocation or a wait in any read or write; a controller that goes takes its
/// wires with it; deactivation takes all.
#[test]
fn the_hexapod_walks_under_a_manager_and_costs_it_nothing() {
    for compiler in compilers(CPP_COMPILERS) {
        let Some(built) = built(compiler, &[]) else { return };
        let rig = hexapod();
        let (driver, _) = Driver::ready(&rig);
        let urdf = source("ros2_control/urdf/hexapod.urdf");
        let said = Process::start(&mut built.task("walk", &rig, urdf.to_str().unwrap())).finish().expect(0).stdout;
        println!("{compiler}: {said}");
        assert!(said.contains("allocations 0\n") && said.contains("sleeps 0\n"), "{said}");
        driver.stop();
    }
}

/// The URDF that a newcomer copies from the page: short, and its joint moves.
#[test]
fn the_urdf_of_the_page_moves_a_wire() {
    let Some(built) = built(compilers(CPP_COMPILERS)[0], &[]) else { return };
    let page = fs::read_to_string(checkout().join("docs/bindings.md")).expect("it is in the checkout");
    let is_urdf = |block: &Block| block.language == "xml" && block.text.contains("<ros2_control");
    let text = blocks(&page).into_iter().find(is_urdf).expect("a URDF").text;
    let rig = hexapod();
    let urdf = rig.file("robot.urdf");
    fs::write(&urdf, format!("<robot name=\"robot\"><link name=\"base\"/>{text}</robot>")).unwrap();
    let (driver, _) = Driver::ready(&rig);
    let said = Process::start(&mut built.task("first", &rig, urdf.to_str().unwrap())).finish().expect(0).stdout;
    for state in ["knee/position 0.", "knee/velocity ", "nan\n", "knee_wire/temperature "] {
        assert!(said.contains(state), "{state}: {said}");
    }
    driver.stop();
}

/// The same on ros2_control's own headers, base class and URDF parser, where somebody has named a checkout of it.
#[test]
fn the_component_stands_on_the_real_hardware_interface() {
    let Some(sources) = std::env::var_os("SINEW_ROS2_CONTROL_SOURCES").map(PathBuf::from) else {
        println!("skipped: SINEW_ROS2_CONTROL_SOURCES names no checkout of ros2_control");
        return;
    };
    let compiler = compilers(CPP_COMPILERS)[0];
    for (header, package) in [
        ("tinyxml2.h", "libtinyxml2-dev"),
        ("fmt/compile.h", "libfmt-dev"),
        ("urdf_parser/urdf_parser.h", "liburdfdom-dev"),
    ] {
        if !has_header(compiler, header, package) {
            return;
        }
    }
    let tests = source("ros2_control/tests");
    let real = ["hardware_interface/include", "joint_limits/include"].map(|folder| sources.join(folder));
    let headers = [&real[..], &["stub_below", "stub"].map(|folder| tests.join(folder))[..]].concat();
    let mut compile = Command::new(compiler);
    compile.args(["-std=c++17", "-w", "-fPIC", "-shared"]);
    for headers in &headers {
        compile.arg("-isystem").arg(headers);
    }
    let names = ["hardware_component_interface", "component_parser", "lexical_casts"];
    compile.args(names.map(|name| sources.join(format!("hardware_interface/src/{name}.cpp"))));
    compile.arg("-o").arg(prefix().join("lib/libhardware_interface.so"));
    succeeds(compile.args(["-lfmt", "-ltinyxml2", "-lurdfdom_model"]));
    let built = built_on(compiler, &[], &headers, &["-lhardware_interface", "-lfmt"]);

    let run = |rig: &Rig, task: &str, more: &str| {
        let (driver, _) = Driver::ready(rig);
        let said = Process::start(&mut built.task(task, rig, more)).finish().expect(0).stdout;
        driver.stop();
        said
    };
    let said = run(&hexapod(), "walk", source("ros2_control/urdf/hexapod.urdf").to_str().unwrap());
    assert!(said.contains("allocations 0\n") && said.contains("sleeps 0\n"), "{said}");
    run(&Rig::bench(&["left", "right"], ""), "kinds", "");
    assert_eq!(run(&Rig::bench(&["left", "right"], ""), "mistakes", ""), "refused all\n");
}

/// Runs a task on a bench under the sanitizers, with each compiler that has them up to so many.
#[track_caller]
fn sanitized(most: usize, rig: impl Fn() -> Rig, task: &str, more: &str, judge: impl Fn(&Finished)) {
    for compiler in sanitizing(CPP_COMPILERS).into_iter().take(most) {
        let Some(built) = built(compiler, SANITIZED) else { return };
        let rig = rig();
        let (driver, _) = Driver::ready(&rig);
        judge(&Process::start(&mut built.task(task, &rig, more)).finish().expect(0));
        driver.stop();
    }
}

#[test]
fn a_manager_finds_every_kind_of_command_and_one_owner_for_each_joint() {
    let bench = || Rig::bench(&["left", "right"], "");
    sanitized(2, bench, "kinds", "", |said| {
        for words in
            ["commanded in two ways", "hip/position is asked for more than its wire can do", "is claimed by process"]
        {
            assert!(said.stderr.contains(words), "{said:?}");
        }
    });
}

#[test]
fn two_wires_of_a_joint_are_one_joint_of_a_manager() {
    let knee = || {
        let mut rig = Rig::bench(&["single"], "");
        for name in ["flexor", "extensor"] {
            rig.add(&format!(
                "\n[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = 0.05, length_mm = 160.0 }}\ntaps = {{ ls_mm = 150.0 }}\n\
                 drive = {{ supply_v = 12.0 }}\n"
            ));
        }
        rig.add("\n[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\nantagonist = \"extensor\"\nradius_mm = 8.0\ninertia_kg_mm2 = 2.5\n");
        rig
    };
    sanitized(2, knee, "antagonists", "", |said| {
        assert!(
            said.stderr.contains("single and flexor are not the wires of one [[joint]] of the rig file"),
            "{said:?}"
        );
    });
}

/// What is wrong with a URDF is said once, on one line, with its place and what would be right.
#[test]
fn what_a_urdf_cannot_mean_is_refused_with_a_remedy() {
    let bench = || Rig::bench(&["left", "right"], "");
    sanitized(2, bench, "mistakes", "", |said| {
        assert_eq!(said.stdout, "refused all\n", "{said:?}");
        let errors: Vec<&str> = said.stderr.lines().filter(|line| line.starts_with("[ERROR]")).collect();
        assert_eq!(errors.len(), 24, "{said:?}");
        for error in &errors {
            assert!(error.contains("the URDF: <") || error.contains("on_configure: "), "{error}");
            assert!(error.contains("; "), "{error}");
        }
        for words in [
            "<hardware> of wires: there is no parameter \"rgi\"; there are hold_s,",
            "hold_s = \"0,5\" is not a number from 0.001 to 3600",
            "<joint> left: two wires turn it, and it has no lever; write radius_mm",
            "<joint> hip: its channel \"left\" is another joint's, too",
            "<sensor> left: there is no state interface \"temprature\"; there are temperature,",
            "did you mean",
        ] {
            assert!(errors.iter().any(|error| error.contains(words)), "{words}: {said:?}");
        }
    });
}

/// A fault switches all off, or what the URDF says, and the log has its cause and its remedy.
#[test]
fn a_fault_deactivates_the_component_and_says_what_to_do() {
    let breaks = "\n[[simulation.fault]]\nchannel = \"left\"\nkind = \"open_wire\"\nstart_s = 6.0\n";
    for on_fault in ["deactivate", "error", "carry_on"] {
        sanitized(
            1,
            || Rig::bench(&["left", "right"], breaks),
            "fault",
            on_fault,
            |said| {
                assert_eq!(said.stdout, "off\n", "{said:?}");
                let first =
                    said.stderr.lines().find(|line| line.starts_with("[ERROR]")).unwrap_or_else(|| panic!("{said:?}"));
                for words in ["hip: left is off: ", "no current", "check wire, crimps and leads"] {
                    assert!(first.contains(words), "{words}: {first}");
                }
                assert_eq!(said.stderr.contains("on_activate: left is off: "), on_fault != "carry_on", "{said:?}");
            },
        );
    }
}

/// A fault whose cause has gone is reset by an activation that is told to; before, the driver's words say why it cannot be.
#[test]
fn an_activation_resets_a_fault_where_it_is_told_to() {
    let breaks = "\n[[simulation.fault]]\nchannel = \"left\"\nkind = \"open_wire\"\nstart_s = 6.0\nend_s = 10.0\n";
    sanitized(
        1,
        || Rig::bench(&["left", "right"], breaks),
        "fault",
        "reset",
        |said| {
            assert!(said.stderr.contains("hip: left is off: "), "{said:?}");
            assert!(said.stderr.contains("on_activate: "), "{said:?}");
        },
    );
}

#[test]
fn a_component_that_is_destroyed_or_a_manager_that_hangs_leaves_no_wire_heated() {
    for how in ["destroyed", "stuck"] {
        sanitized(
            1,
            || Rig::bench(&["left", "right"], ""),
            "hold",
            how,
            |said| assert_eq!(said.stdout, "holding\n", "{said:?}"),
        );
    }
}

/// Waits until both wires get the sensing pulse and no more, and cool.
#[track_caller]
fn goes_cold(observer: &Client) {
    let off = wait_for("the leases to run out", || {
        let channels = observer.latest().channels().to_vec();
        channels.iter().all(|c| c.mode() == Mode::Lapsed).then_some(channels)
    });
    assert!(off.iter().all(|c| c.fault().is_none() && c.duty == SENSING_DUTY), "{off:?}");
    wait_until("the wires to cool", || {
        observer.latest().channels().iter().zip(&off).all(|(now, then)| now.temperature_c < then.temperature_c - 3.0)
    });
}

/// A manager that is killed in the middle of its loop renews nothing: its wires go off, and its claim ends with it.
#[test]
fn a_manager_that_is_killed_leaves_no_wire_heated() {
    let Some(built) = built(compilers(CPP_COMPILERS)[0], &[]) else { return };
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, observer) = Driver::ready(&rig);
    for (round, how) in (0..).zip(["", "claimed", "claimed"]) {
        let mut manager = Process::start(&mut built.task("hold", &rig, how));
        manager.wait_for_word("holding");
        std::thread::sleep(Duration::from_micros(round * 3170));
        let owner = observer.latest().channels()[0].owner;
        assert_eq!(owner, if how.is_empty() { 0 } else { manager.pid() });
        manager.kill();
        goes_cold(&observer);
    }
    wait_until("the claim to end", || observer.set_stroke("left", 0.1, Duration::from_millis(100)).is_ok());
    let report = driver.stop();
    assert!(report["leases_lapsed"].as_u64() >= Some(6), "{report:#}");
}

/// A driver that is killed ends the component with an error, and the next driver is taken on.
#[test]
fn a_driver_that_is_killed_is_told_and_the_next_one_is_taken_on() {
    let Some(built) = built(compilers(CPP_COMPILERS)[0], &[]) else { return };
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, observer) = Driver::ready(&rig);
    let mut manager = Process::start(&mut built.task("hold", &rig, ""));
    manager.wait_for_word("holding");
    driver.process.kill();
    drop(observer);
    manager.wait_for_word("gone");
    let (driver, observer) = Driver::ready(&rig);
    let said = manager.finish().expect(0);
    assert!(said.stdout.ends_with("moved again\n"), "{said:?}");
    assert!(said.stderr.contains("start it again with `sinew run`"), "{said:?}");
    wait_until("the wires to be off", || observer.latest().channels().iter().all(|c| c.mode() == Mode::Off));
    driver.stop();
}
