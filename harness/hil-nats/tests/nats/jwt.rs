//! Credentials as `nsc` creates them: an operator vouches for an account, which vouches for a user (NATS by example,
//! "Decentralized JWT authentication"; claims of github.com/nats-io/jwt, version 2).

use data_encoding::BASE64URL_NOPAD;
use nkeys::KeyPair;
use serde_json::{Value, json};

/// Configuration of a server that trusts one operator, and credentials of one user.
pub struct Trust {
    /// Configuration of the server.
    pub config: String,
    /// The user's file, as `nsc generate creds` writes it.
    pub creds: String,
    /// The file of a user whose account no operator vouches for.
    pub stranger: String,
}

impl Trust {
    pub fn new() -> Self {
        let (operator, account, user) =
            (KeyPair::new_operator(), KeyPair::new_account(), KeyPair::new_user());
        let unlimited = json!({
            "subs": -1, "data": -1, "payload": -1, "imports": -1, "exports": -1, "wildcards": true,
            "conn": -1, "leaf": -1, "mem_storage": -1, "disk_storage": -1, "streams": -1, "consumer": -1,
        });
        let itself = claims(&operator, &operator, "operator", &json!({}));
        let of_account = claims(&operator, &account, "account", &json!({ "limits": unlimited }));
        // With streams, the server needs an account of its own.
        let system = KeyPair::new_account();
        let of_system = claims(&operator, &system, "account", &json!({}));
        let (account_name, system_name) = (account.public_key(), system.public_key());
        let config = format!(
            "operator: {itself}\nsystem_account: {system_name}\nresolver: MEMORY\n\
             resolver_preload: {{ {account_name}: {of_account}, {system_name}: {of_system} }}\n"
        );
        let stranger = creds(&KeyPair::new_account(), &user);
        Self { config, creds: creds(&account, &user), stranger }
    }
}

/// Returns the claims of `issuer` about `subject`, signed.
fn claims(issuer: &KeyPair, subject: &KeyPair, kind: &str, of_kind: &Value) -> String {
    let mut nats = of_kind.clone();
    nats["type"] = kind.into();
    nats["version"] = 2.into();
    let (issued_by, about) = (issuer.public_key(), subject.public_key());
    let body = json!({
        // Made once, in November 2023.
        "jti": about, "iat": 1_700_000_000, "iss": issued_by, "name": kind, "sub": about, "nats": nats,
    });
    let encoded = |value: Value| BASE64URL_NOPAD.encode(value.to_string().as_bytes());
    let header = json!({ "typ": "JWT", "alg": "ed25519-nkey" });
    let said = format!("{}.{}", encoded(header), encoded(body));
    let signature = issuer.sign(said.as_bytes()).unwrap();
    format!("{said}.{}", BASE64URL_NOPAD.encode(&signature))
}

/// Returns a credentials file: the claims of `account` about `user`, and the user's key.
fn creds(account: &KeyPair, user: &KeyPair) -> String {
    let limits = json!({ "pub": {}, "sub": {}, "subs": -1, "data": -1, "payload": -1 });
    let (jwt, seed) = (claims(account, user, "user", &limits), user.seed().unwrap());
    format!(
        "-----BEGIN NATS USER JWT-----\n{jwt}\n------END NATS USER JWT------\n\n\
         -----BEGIN USER NKEY SEED-----\n{seed}\n------END USER NKEY SEED------\n"
    )
}
