"""An OpenID provider for tests: ``python provider.py REDIRECT_URI PORT``.

Authlib's server side: authorization code with PKCE (S256) and nonce, an RSA key behind a JWKS, and
a log-out of its own. Its page asks which of its people one is; no passwords.
"""

from __future__ import annotations

import secrets
import sys
import time
from dataclasses import dataclass
from typing import Any

import uvicorn
from authlib.oauth2 import AuthorizationServer, OAuth2Request
from authlib.oauth2.rfc6749 import ClientMixin
from authlib.oauth2.rfc6749.grants import AuthorizationCodeGrant
from authlib.oauth2.rfc6749.requests import BasicOAuth2Payload
from authlib.oauth2.rfc6750 import BearerTokenGenerator
from authlib.oauth2.rfc7636 import CodeChallenge
from authlib.oidc.core import OpenIDCode
from joserfc.jwk import KeySet, RSAKey
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import (
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
    RedirectResponse,
    Response,
)
from starlette.routing import Route

CLIENT, SECRET = "nvcore", "of the tests"
PEOPLE = {
    "anna": {"name": "Anna", "email": "anna@lab.example", "email_verified": True},
    "bert": {"name": "Bert", "email": "bert@lab.example", "email_verified": True},
    "carl": {"name": "Carl", "email": "carl@elsewhere.example", "email_verified": True},
    "dora": {"name": "Dora", "email": "dora@lab.example", "email_verified": False},
}
KEY = RSAKey.generate_key(2048, {"kid": "tests", "use": "sig", "alg": "RS256"})


@dataclass
class Client(ClientMixin):
    redirect_uri: str

    def get_client_id(self) -> str:
        return CLIENT

    def get_default_redirect_uri(self) -> str:
        return self.redirect_uri

    def get_allowed_scope(self, scope: str) -> str:
        return scope

    def check_redirect_uri(self, redirect_uri: str) -> bool:
        return redirect_uri == self.redirect_uri

    def check_client_secret(self, client_secret: str) -> bool:
        return secrets.compare_digest(client_secret, SECRET)

    def check_endpoint_auth_method(self, method: str, endpoint: str) -> bool:
        return method == "client_secret_basic"

    def check_response_type(self, response_type: str) -> bool:
        return response_type == "code"

    def check_grant_type(self, grant_type: str) -> bool:
        return grant_type == "authorization_code"


@dataclass
class Code:
    code: str
    user: str
    redirect_uri: str
    scope: str
    nonce: str
    code_challenge: str
    code_challenge_method: str

    def get_redirect_uri(self) -> str:
        return self.redirect_uri

    def get_scope(self) -> str:
        return self.scope

    def get_nonce(self) -> str:
        return self.nonce

    def get_auth_time(self) -> int:
        return int(time.time())

    def get_acr(self) -> None:
        return None

    def get_amr(self) -> None:
        return None


codes: dict[str, Code] = {}
nonces: set[str] = set()


class CodeGrant(AuthorizationCodeGrant):
    TOKEN_ENDPOINT_AUTH_METHODS = ("client_secret_basic",)

    def save_authorization_code(self, code: str, request: OAuth2Request) -> None:
        given = request.payload.data
        names = ("redirect_uri", "scope", "nonce", "code_challenge", "code_challenge_method")
        nonces.add(given["nonce"])
        codes[code] = Code(code, request.user, *(given[name] for name in names))

    def query_authorization_code(self, code: str, client: Client) -> Code | None:
        return codes.get(code)

    def delete_authorization_code(self, authorization_code: Code) -> None:
        del codes[authorization_code.code]

    def authenticate_user(self, authorization_code: Code) -> str:
        return authorization_code.user


class IdToken(OpenIDCode):
    def __init__(self, issuer: str) -> None:
        super().__init__(require_nonce=True)
        self.issuer = issuer

    def exists_nonce(self, nonce: str, request: OAuth2Request) -> bool:
        return nonce in nonces

    def resolve_client_private_key(self, client: Client) -> KeySet:
        return KeySet([KEY])

    def get_client_claims(self, client: Client) -> dict[str, Any]:
        return {"iss": self.issuer, "aud": [client.get_client_id()]}

    def generate_user_info(self, user: str, scope: str) -> dict[str, Any]:
        return {"sub": user, **PEOPLE[user]}


class Server(AuthorizationServer):
    def __init__(self, client: Client) -> None:
        super().__init__(scopes_supported=["openid", "email", "profile"])
        self.client = client
        make = BearerTokenGenerator(lambda **_: secrets.token_urlsafe(24))
        self.register_token_generator("default", make)

    def query_client(self, client_id: str) -> Client | None:
        return self.client if client_id == CLIENT else None

    def save_token(self, token: dict[str, Any], request: OAuth2Request) -> None:
        """Nobody asks for it again."""

    def create_oauth2_request(self, request: OAuth2Request) -> OAuth2Request:
        return request

    def handle_response(self, status: int, body: Any, headers: Any) -> Response:
        if isinstance(body, dict):
            return JSONResponse(body, status, dict(headers))
        return Response(body, status, dict(headers))

    def send_signal(self, name: str, *args: Any, **kwargs: Any) -> None:
        """Nobody listens."""


class FormRequest(OAuth2Request):
    def __init__(self, request: Request, form: dict[str, str]) -> None:
        super().__init__(request.method, str(request.url), headers=request.headers)
        self.fields, self.queried = form, dict(request.query_params)
        self.payload = BasicOAuth2Payload({**self.queried, **form})

    @property
    def args(self) -> dict[str, str]:
        return self.queried

    @property
    def form(self) -> dict[str, str]:
        return self.fields


def application(redirect_uri: str, port: int) -> Starlette:
    issuer = f"http://127.0.0.1:{port}"
    server = Server(Client(redirect_uri))
    server.register_grant(CodeGrant, [CodeChallenge(required=True), IdToken(issuer)])

    async def metadata(request: Request) -> Response:
        return JSONResponse(
            {
                "issuer": issuer,
                "authorization_endpoint": f"{issuer}/authorize",
                "token_endpoint": f"{issuer}/token",
                "jwks_uri": f"{issuer}/jwks",
                "end_session_endpoint": f"{issuer}/end",
                "response_types_supported": ["code"],
                "subject_types_supported": ["public"],
                "id_token_signing_alg_values_supported": ["RS256"],
                "code_challenge_methods_supported": ["S256"],
            }
        )

    async def authorize(request: Request) -> Response:
        user = request.query_params.get("user")
        if user in PEOPLE:
            asked = FormRequest(request, {})
            grant = server.get_consent_grant(asked, user)
            return server.create_authorization_response(asked, user, grant)
        links = (f'<a href="{request.url}&amp;user={name}">{name}</a>' for name in PEOPLE)
        return HTMLResponse(f"<title>Provider</title><h1>Who are you?</h1>{' '.join(links)}")

    async def token(request: Request) -> Response:
        form = {name: str(value) for name, value in (await request.form()).items()}
        return server.create_token_response(FormRequest(request, form))

    async def keys(request: Request) -> Response:
        return JSONResponse(KeySet([KEY]).as_dict(private=False))

    async def end(request: Request) -> Response:
        wanted = request.query_params["post_logout_redirect_uri"]
        if wanted != redirect_uri or not request.query_params.get("id_token_hint"):
            return PlainTextResponse("unknown", 400)
        return RedirectResponse(wanted)

    async def health(request: Request) -> Response:
        return PlainTextResponse("ok")

    return Starlette(
        routes=[
            Route("/.well-known/openid-configuration", metadata),
            Route("/authorize", authorize),
            Route("/token", token, methods=["POST"]),
            Route("/jwks", keys),
            Route("/end", end),
            Route("/_stcore/health", health),
        ]
    )


if __name__ == "__main__":
    uvicorn.run(
        application(sys.argv[1], int(sys.argv[2])),
        host="127.0.0.1",
        port=int(sys.argv[2]),
        log_level="warning",
    )
