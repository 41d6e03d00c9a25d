//! `sinew design`: from requirements to a rig file that the other commands take.

use crate::support::Scratch;

#[test]
fn a_designed_wire_is_a_rig() {
    let scratch = Scratch::new();
    scratch.sinew(["design", "--force", "1.5N", "--stroke", "6mm", "--cycle", "3s", "-o", "muscle.toml"]).done();
    let tuned = scratch.sinew(["tune", "muscle.toml"]).done();
    assert!(tuned.contains("as modelled"), "{tuned}");
    let joint = scratch.sinew(["design", "--torque", "30mNm", "--angle", "60deg", "--span", "200mm"]).done();
    assert!(joint.contains("pulley or lever of 7.64 mm"), "{joint}");
}

#[test]
fn what_cannot_be_done_says_what_to_change() {
    let scratch = Scratch::new();
    scratch
        .sinew(["design", "--force", "20N", "--stroke", "6mm", "--cycle", "0.1"])
        .refused(&["no wire does all of that", "--cycle"]);
    scratch.sinew(["design", "--force", "2N", "--stroke", "6mm", "--supply", "1V"]).refused(&["--supply"]);
    scratch.sinew(["design", "--force", "2", "--stroke", "6mm"]).refused(&["as in 2N"]);
    scratch.sinew(["design", "--force", "2N"]).refused(&["--stroke"]);
    scratch.sinew(["design"]).refused(&["--force"]);
}
