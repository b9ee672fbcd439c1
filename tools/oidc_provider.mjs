// A provider of logins for tools/check_login.py: the npm package oidc-provider, which lets anybody in under any name.
// usage: node oidc_provider.mjs PORT CLIENT SECRET RETURN_ADDRESS
import { Provider } from 'oidc-provider';

const [port, client, secret, back] = process.argv.slice(2);
const provider = new Provider(`http://127.0.0.1:${port}`, {
  clients: [{ client_id: client, client_secret: secret, redirect_uris: [back] }],
  claims: { openid: ['sub'], profile: ['preferred_username'], email: ['email', 'email_verified'] },
  findAccount: (_, id) => ({ accountId: id, claims: () => ({ sub: id, preferred_username: id, email: `${id}@example.com`, email_verified: true }) }),
});
provider.listen(Number(port), '127.0.0.1', () => console.log('the provider listens'));
