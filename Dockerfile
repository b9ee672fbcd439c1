# One image, one binary: coordinator and workers are subcommands of it.
# Tags name versions. To fix the very bits, give images by digest: --build-arg RUST_IMAGE=rust@sha256:…
ARG RUST_IMAGE=rust:1.95.0-slim-trixie
ARG DEBIAN_IMAGE=debian:13.6-slim

FROM ${RUST_IMAGE} AS build
WORKDIR /source
COPY . .
# It is stripped after the build: a setting of the build would make it another build, and farms take only equal ones.
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/source/target \
    cargo build --release --locked && strip --strip-all -o /photonfarm target/release/photonfarm

FROM ${DEBIAN_IMAGE}
# Certificates are for buckets and coordinators that are reached by TLS.
# hadolint ignore=DL3008
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates && rm -rf /var/lib/apt/lists/* \
    && useradd --system --uid 10001 --no-create-home photonfarm && install -d -o photonfarm /data
COPY --from=build /photonfarm /usr/local/bin/photonfarm
USER 10001
ENV PHOTONFARM_DATA=/data
VOLUME /data
EXPOSE 8080
# It asks the coordinator that PHOTONFARM_URL names, or else the one in this container.
HEALTHCHECK --interval=10s --timeout=5s --start-period=30s CMD ["photonfarm", "health"]
ENTRYPOINT ["photonfarm"]
CMD ["serve", "--listen", "0.0.0.0:8080"]
