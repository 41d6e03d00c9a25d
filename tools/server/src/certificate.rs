//! The certificate a server shows on the network: self-signed, made once and kept.
//!
//! No authority vouches for a machine in a laboratory, so a browser warns, and its user makes an exception for this very
//! certificate. That is why it is kept: one fingerprint is to be compared for years, and a browser that still remembers it and warns has
//! met another certificate, and perhaps another server.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::net::IpAddr;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rcgen::{CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, KeyPair, date_time_ymd};
use rustls::ServerConfig;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use sha2::{Digest, Sha256};
use tokio_rustls::TlsAcceptor;

/// How long it is valid. Apple's devices take none that is valid for more than 825 days.
const VALID: Duration = Duration::from_secs(820 * 24 * 3600);
/// A device whose clock is behind takes it at once.
const BEFORE: Duration = Duration::from_secs(24 * 3600);
/// It is used for so long, and then another one is made: it is not to run out while somebody looks on.
const KEPT: Duration = Duration::from_secs(730 * 24 * 3600);
/// Key and certificate are a kilobyte; what is larger is neither.
const MOST_BYTES: u64 = 64 << 10;

/// A certificate with its key, ready to be shown.
#[derive(Clone)]
pub struct Certificate {
    der: CertificateDer<'static>,
    config: Arc<ServerConfig>,
    is_new: bool,
}

impl Certificate {
    /// The one kept in this file (PEM, key and certificate). A new one for `names` is made and kept where there is none, where it has
    /// become old or is damaged, and where anybody else could have read the key or put it there.
    ///
    /// # Errors
    /// The system's, where the file cannot be read or written.
    pub fn kept(path: &Path, names: &[String]) -> io::Result<Certificate> {
        if let Some(text) = read(path)?
            && let Some(certificate) = Certificate::of_pem(&text)
        {
            return Ok(certificate);
        }
        let text = make(names).map_err(io::Error::other)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder)?;
        // for this user alone, and whole or not there
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(text.as_bytes())?;
        file.persist(path)?;
        let made =
            Certificate::of_pem(text.as_bytes()).ok_or(io::Error::other("the new certificate cannot be used"))?;
        Ok(Certificate { is_new: true, ..made })
    }

    /// Of a file's text, if a key and its certificate are in there.
    fn of_pem(text: &[u8]) -> Option<Certificate> {
        let der = CertificateDer::from_pem_slice(text).ok()?;
        let key = PrivateKeyDer::from_pem_slice(text).ok()?;
        // every browser of the last years speaks 1.3, which has none of the older ones' weak ciphers
        let mut config = ServerConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_protocol_versions(&[&rustls::version::TLS13])
            .ok()?
            .with_no_client_auth()
            .with_single_cert(vec![der.clone()], key)
            .ok()?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Some(Certificate { der, config: Arc::new(config), is_new: false })
    }

    /// Whether it was made just now: every browser will warn.
    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// What it is told from all others by: its SHA-256, as browsers show it, `3A:F0:…`.
    pub fn fingerprint(&self) -> String {
        let pairs: Vec<String> = Sha256::digest(&self.der).iter().map(|byte| format!("{byte:02X}")).collect();
        pairs.join(":")
    }

    /// The certificate itself, DER.
    pub fn der(&self) -> &[u8] {
        &self.der
    }

    pub(crate) fn acceptor(&self) -> TlsAcceptor {
        TlsAcceptor::from(self.config.clone())
    }
}

/// What is in the file; nothing where there is none, or none to be trusted any more.
fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let file = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    let about = file.metadata()?;
    let is_own = about.is_file() && about.uid() == rustix::process::geteuid().as_raw() && about.mode() & 0o077 == 0;
    // one from the future was made while the clock was wrong, and so is valid at the wrong time
    let is_old = SystemTime::now().duration_since(about.modified()?).map_or(true, |age| age > KEPT);
    if !is_own || is_old {
        return Ok(None);
    }
    let mut text = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut text)?;
    Ok(Some(text))
}

/// A new key and its certificate for these names and addresses, as PEM.
fn make(names: &[String]) -> Result<String, rcgen::Error> {
    let epoch = date_time_ymd(1970, 1, 1);
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let key = KeyPair::generate()?;
    let mut params = CertificateParams::new(names)?;
    params.not_before = epoch + now.saturating_sub(BEFORE);
    params.not_after = epoch + now + VALID;
    params.distinguished_name = DistinguishedName::new();
    let host = names.iter().find(|name| name.parse::<IpAddr>().is_err()).map_or("this machine", String::as_str);
    params.distinguished_name.push(DnType::CommonName, format!("sinew on {host}"));
    params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
    let certificate = params.self_signed(&key)?;
    Ok(pem("PRIVATE KEY", &key.serialize_der()) + &pem("CERTIFICATE", certificate.der()))
}

/// RFC 7468.
fn pem(label: &str, der: &[u8]) -> String {
    let text = STANDARD.encode(der);
    let lines: Vec<&str> = (0..text.len()).step_by(64).map(|at| &text[at..text.len().min(at + 64)]).collect();
    format!("-----BEGIN {label}-----\n{}\n-----END {label}-----\n", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn it_is_kept_and_made_anew_where_it_cannot_be_trusted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state/scope.pem");
        let names = ["bench".to_string(), "bench.local".to_string(), "192.0.2.7".to_string(), "::1".to_string()];
        let kept = || Certificate::kept(&path, &names).unwrap();
        let first = kept();
        assert!(first.is_new());
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        assert_eq!((first.fingerprint().len(), first.fingerprint().matches(':').count()), (95, 31));
        let again = kept();
        assert!(!again.is_new() && again.fingerprint() == first.fingerprint() && again.der() == first.der());

        let mut last = first.fingerprint();
        let whole = fs::read(&path).unwrap();
        let spoils: [(&str, &dyn Fn()); 5] = [
            ("readable by others", &|| fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap()),
            ("old", &|| File::open(&path).unwrap().set_modified(SystemTime::now() - KEPT - BEFORE).unwrap()),
            ("of the future", &|| File::open(&path).unwrap().set_modified(SystemTime::now() + BEFORE).unwrap()),
            ("cut", &|| File::options().write(true).open(&path).unwrap().set_len(300).unwrap()),
            // the first one's key, with which nothing it has since signed agrees
            ("another's", &|| {
                let now = fs::read(&path).unwrap();
                let half = |text: &[u8]| String::from_utf8_lossy(text).find("-----BEGIN CERT").unwrap();
                fs::write(&path, [&whole[..half(&whole)], &now[half(&now)..]].concat()).unwrap();
            }),
        ];
        for (what, spoil) in spoils {
            spoil();
            let anew = kept();
            assert!(anew.is_new() && anew.fingerprint() != last, "{what}");
            last = anew.fingerprint();
            assert!(!kept().is_new(), "{what}");
        }
        let error = Certificate::kept(&folder.path().join("state/scope.pem/in it"), &names).err().unwrap();
        assert_eq!(error.kind(), io::ErrorKind::NotADirectory);
    }
}
