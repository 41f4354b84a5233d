//! Servers with authentication, of clients and of themselves.

use crate::hil::Hil;
use crate::jwt::Trust;
use crate::server::Server;
use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, IsCa, KeyPair};
use std::path::Path;

/// A campaign of a few cases with a worker of the same credentials.
fn goes(hil: &Hil, url: &str, credentials: &[&str]) {
    let start = |name, arguments: &[&str]| {
        let mut arguments = [arguments, &["--nats", url]].concat();
        arguments.extend(credentials);
        hil.start(name, &arguments)
    };
    let worker = start("worker", &["worker"]);
    let over = start("over", &["campaign", "live-side", "--cases", "3", "--json"]);
    let ran = over.ends();
    assert!(matches!(ran.status, Some(0 | 1)), "{ran:#?}\n{}", worker.err());
    assert_eq!(ran.campaign()["cases"], 3);
}

fn refused(hil: &Hil, url: &str, credentials: &[&str], help: &str) {
    let mut arguments = vec!["worker", "--nats", url];
    arguments.extend(credentials);
    let ran = hil.start("refused", &arguments).ends().exits(2);
    assert!(ran.err.contains("failed to connect to "), "{}", ran.err);
    assert!(ran.err.contains(help), "{}", ran.err);
    assert!(!ran.err.contains("secret"), "a password is shown: {}", ran.err);
}

#[test]
fn a_user_and_a_password() {
    let arguments = ["--user", "hil", "--pass", "top secret"];
    let Some(server) = Server::start_with(&arguments) else { return };
    let hil = Hil::new();
    refused(&hil, &server.url(), &[], "--creds");
    refused(&hil, &format!("nats://hil:secret@{}", server.address()), &[], "--creds");
    goes(&hil, &format!("nats://hil:top%20secret@{}", server.address()), &[]);
}

/// A key pair from the server's manual (Developing With NATS, NKeys): it gives access to nothing.
const SEED: &str = "SUACSSL3UAHUDXKFSNVUZRF5UHPMWZ6BFDTJ7M6USDXIEDNPPQYYYCU3VY";
const PUBLIC: &str = "UDXU4RCSJNZOIQHZNWXHXORDPRTGNJAHAHFRGZNEEJCPQTT2M7NLCNF4";

#[test]
fn an_nkey() {
    let hil = Hil::new();
    let config = format!("authorization: {{ users: [ {{ nkey: {PUBLIC} }} ] }}\n");
    std::fs::write(hil.path("server.conf"), config).unwrap();
    std::fs::write(hil.path("seed.txt"), format!("{SEED}\n")).unwrap();
    let config = hil.path("server.conf").display().to_string();
    let Some(server) = Server::start_with(&["--config", &config]) else { return };
    refused(&hil, &server.url(), &[], "--nkey");
    goes(&hil, &server.url(), &["--nkey", "seed.txt"]);
}

#[test]
fn credentials_of_an_operators_account() {
    let hil = Hil::new();
    let trust = Trust::new();
    std::fs::write(hil.path("server.conf"), &trust.config).unwrap();
    std::fs::write(hil.path("user.creds"), &trust.creds).unwrap();
    std::fs::write(hil.path("stranger.creds"), &trust.stranger).unwrap();
    let config = hil.path("server.conf").display().to_string();
    let Some(server) = Server::start_with(&["--config", &config]) else { return };
    refused(&hil, &server.url(), &[], "--creds");
    refused(&hil, &server.url(), &["--creds", "stranger.creds"], "--creds");
    goes(&hil, &server.url(), &["--creds", "user.creds"]);
}

/// Writes a certificate signed by `issuer`, and its key.
fn certificate(folder: &Path, name: &str, issuer: &CertifiedIssuer<'_, KeyPair>) {
    let key = KeyPair::generate().unwrap();
    let parameters = CertificateParams::new(vec!["127.0.0.1".to_owned()]).unwrap();
    let certificate = parameters.signed_by(&key, issuer).unwrap();
    std::fs::write(folder.join(format!("{name}.pem")), certificate.pem()).unwrap();
    std::fs::write(folder.join(format!("{name}-key.pem")), key.serialize_pem()).unwrap();
}

#[test]
fn certificates_of_both_sides() {
    let hil = Hil::new();
    let mut parameters = CertificateParams::new(Vec::new()).unwrap();
    parameters.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let authority = CertifiedIssuer::self_signed(parameters, KeyPair::generate().unwrap()).unwrap();
    std::fs::write(hil.path("ca.pem"), authority.pem()).unwrap();
    certificate(&hil.path(""), "server", &authority);
    certificate(&hil.path(""), "client", &authority);
    let file = |name: &str| hil.path(name).display().to_string();
    let (ca, cert, key) = (file("ca.pem"), file("server.pem"), file("server-key.pem"));
    let Some(server) = Server::start_with(&[
        "--tls",
        "--tlsverify",
        "--tlscacert",
        &ca,
        "--tlscert",
        &cert,
        "--tlskey",
        &key,
    ]) else {
        return;
    };
    let url = format!("tls://{}", server.address());
    refused(&hil, &url, &[], "");
    refused(&hil, &url, &["--tls-ca", "ca.pem"], "");
    let client = ["--tls-ca", "ca.pem", "--tls-cert", "client.pem", "--tls-key", "client-key.pem"];
    goes(&hil, &url, &client);
}
