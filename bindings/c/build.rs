//! Gives the shared library its name, which programs remember: with another layout it is another one, and an old program is
//! told so by the loader instead of reading the wrong bytes.

/// Version of the calls and structs of `sinew.h`. Every change that a program built before would notice raises it.
const ABI: u32 = 3;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=SINEW_ABI={ABI}");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libsinew.so.{ABI}");
}
