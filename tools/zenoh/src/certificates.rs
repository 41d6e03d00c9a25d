//! The certificates by which bridge and clients know each other: an authority of the user's own, kept in a folder.
//!
//! Whoever has a certificate of this authority may connect; whoever's is the name of a commander may command. The bridge's
//! certificate is good for servers alone and all others for clients alone, so nobody who was let in can pass for the bridge.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose, date_time_ymd,
};

use crate::failure::{Failure, Outcome};
use crate::keys::is_name;

/// The authority.
const AUTHORITY: &str = "authority";
/// The bridge.
const BRIDGE: &str = "bridge";
/// A device whose clock is behind takes a certificate at once.
const BEFORE: Duration = Duration::from_secs(24 * 3600);
/// How long the certificates are valid; a link whose certificate runs out is closed.
const VALID: Duration = Duration::from_secs(820 * 24 * 3600);
/// And the authority.
const AUTHORITY_VALID: Duration = Duration::from_secs(3650 * 24 * 3600);

/// A folder with certificates, as `sinew-zenoh certificates` makes it: `NAME.pem` and `NAME.key` of each.
#[derive(Debug, Clone)]
pub struct Certificates(PathBuf);

impl Certificates {
    /// The folder to be used for a bridge.
    ///
    /// # Errors
    /// One without what a bridge needs.
    pub fn open(folder: &Path) -> Result<Certificates, Failure> {
        let certificates = Certificates(folder.into());
        for file in [certificates.authority(), certificates.certificate(), certificates.key()] {
            fs::File::open(&file).map_err(|error| {
                Failure::input(format_args!("{}: {error}", file.display()))
                    .hint(format_args!("make them with `sinew-zenoh certificates {} NAME`", folder.display()))
            })?;
        }
        Ok(certificates)
    }

    /// The authority's certificate.
    pub fn authority(&self) -> PathBuf {
        self.file(AUTHORITY, "pem")
    }

    /// The bridge's certificate.
    pub fn certificate(&self) -> PathBuf {
        self.file(BRIDGE, "pem")
    }

    /// The bridge's key.
    pub fn key(&self) -> PathBuf {
        self.file(BRIDGE, "key")
    }

    fn file(&self, name: &str, kind: &str) -> PathBuf {
        self.0.join(format!("{name}.{kind}"))
    }

    /// Keeps a certificate and its key; the key first, which is for this user alone.
    fn keep(&self, name: &str, certificate: &str, key: &KeyPair) -> Outcome {
        let write = |kind: &str, mode: u32, text: &str| {
            let file = self.file(name, kind);
            let opened = OpenOptions::new().write(true).create_new(true).mode(mode).open(&file);
            opened.and_then(|mut file| file.write_all(text.as_bytes())).map_err(|e| unwritable(&file, &e))
        };
        write("key", 0o600, &key.serialize_pem())?;
        write("pem", 0o644, certificate)
    }
}

/// `sinew-zenoh certificates`: makes what is not there yet, in this folder, and says what; nothing that is there is touched.
///
/// # Errors
/// A name that cannot be one or is there already, a folder that cannot be written to, an authority that cannot be read.
pub fn make(folder: &Path, hosts: &[String], names: &[String]) -> Result<Vec<String>, Failure> {
    if let Some(bad) = names.iter().find(|name| !is_name(name) || [AUTHORITY, BRIDGE].contains(&name.as_str())) {
        return Err(Failure::input(format_args!("{bad}: no name of a client")).hint(
            "use letters, digits, '-', '_' and '.', a letter or digit first, and neither `authority` nor `bridge`",
        ));
    }
    let there = Certificates(folder.into());
    if let Some(old) = names.iter().find(|name| there.file(name, "pem").exists() || there.file(name, "key").exists()) {
        return Err(Failure::input(format_args!("{old} has a certificate in {} already", folder.display()))
            .hint("remove its files there to make another one; the old one stays good until it runs out"));
    }
    fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    let mut made = Vec::new();
    let issuer = match there.authority().exists() {
        true => read_authority(&there)?,
        false => {
            let params = authority(folder);
            let key = key()?;
            let certificate = params.self_signed(&key).map_err(not_made)?;
            there.keep(AUTHORITY, &certificate.pem(), &key)?;
            made.push(AUTHORITY.into());
            Issuer::new(params, key)
        }
    };
    let bridge = (!there.certificate().exists()).then_some((BRIDGE, ExtendedKeyUsagePurpose::ServerAuth));
    let clients = names.iter().map(|name| (name.as_str(), ExtendedKeyUsagePurpose::ClientAuth));
    for (name, purpose) in bridge.into_iter().chain(clients) {
        let hosts: Vec<String> = if name == BRIDGE { with_loopback(hosts) } else { Vec::new() };
        let mut params = CertificateParams::new(hosts)
            .map_err(|error| Failure::input(error).hint("give --host a name or an address of the bridge's machine"))?;
        valid_for(&mut params, VALID);
        params.distinguished_name = common_name(name);
        params.extended_key_usages = vec![purpose];
        params.use_authority_key_identifier_extension = true;
        let key = key()?;
        let certificate = params.signed_by(&key, &issuer).map_err(not_made)?;
        there.keep(name, &certificate.pem(), &key)?;
        made.push(name.into());
    }
    Ok(made)
}

fn authority(folder: &Path) -> CertificateParams {
    let mut params = CertificateParams::default();
    valid_for(&mut params, AUTHORITY_VALID);
    params.distinguished_name = common_name(&format!("sinew {}", folder.display()));
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    params
}

fn read_authority(there: &Certificates) -> Result<Issuer<'static, KeyPair>, Failure> {
    let read = |file: PathBuf| {
        fs::read_to_string(&file).map_err(|error| Failure::input(format_args!("{}: {error}", file.display())))
    };
    let (certificate, key) = (read(there.authority())?, read(there.file(AUTHORITY, "key"))?);
    KeyPair::from_pem(&key).and_then(|key| Issuer::from_ca_cert_pem(&certificate, key)).map_err(|error| {
        Failure::input(format_args!("{}: {error}", there.authority().display()))
            .hint("begin a new folder: all its certificates come from one authority")
    })
}

fn with_loopback(hosts: &[String]) -> Vec<String> {
    let mut all: Vec<String> = vec!["localhost".into(), "127.0.0.1".into(), "::1".into()];
    all.extend(hosts.iter().filter(|host| !all.contains(host)).cloned().collect::<Vec<_>>());
    all
}

fn common_name(name: &str) -> DistinguishedName {
    let mut distinguished = DistinguishedName::new();
    distinguished.push(DnType::CommonName, name);
    distinguished
}

fn valid_for(params: &mut CertificateParams, time: Duration) {
    let epoch = date_time_ymd(1970, 1, 1);
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    params.not_before = epoch + now.saturating_sub(BEFORE);
    params.not_after = epoch + now + time;
}

fn key() -> Result<KeyPair, Failure> {
    KeyPair::generate().map_err(not_made)
}

fn not_made(error: rcgen::Error) -> Failure {
    Failure::own(format_args!("no certificate could be made: {error}"))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::input(format_args!("{}: {error}", path.display())).hint("choose a folder that can be written to")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_folder_grows_and_keeps_what_it_has() {
        let folder = tempfile::tempdir().unwrap();
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(make(folder.path(), &[], &names(&["anna"])).unwrap(), ["authority", "bridge", "anna"]);
        let before = fs::read(folder.path().join("authority.pem")).unwrap();
        assert_eq!(make(folder.path(), &[], &names(&["bert"])).unwrap(), ["bert"]);
        assert_eq!(fs::read(folder.path().join("authority.pem")).unwrap(), before);
        for name in ["authority", "bridge", "anna", "bert"] {
            let mode = fs::metadata(folder.path().join(format!("{name}.key"))).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600, "{name}");
        }
        assert!(Certificates::open(folder.path()).is_ok());
        // nothing is made where anything is amiss
        for bad in [&["anna"][..], &["bridge"], &["carl", "a/b"], &["carl", "authority"]] {
            assert_eq!(make(folder.path(), &[], &names(bad)).unwrap_err().code(), 2, "{bad:?}");
        }
        assert!(!folder.path().join("carl.pem").exists());
        assert!(Certificates::open(&folder.path().join("none")).is_err());
        fs::write(folder.path().join("authority.pem"), "nonsense").unwrap();
        assert_eq!(make(folder.path(), &[], &names(&["carl"])).unwrap_err().code(), 2);
    }
}
