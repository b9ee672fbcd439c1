# One image, one binary: coordinator and workers are subcommands of it.
FROM rust:1-slim-trixie AS build
WORKDIR /source
COPY . .
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/source/target \
    cargo build --release --locked && cp target/release/photonfarm /photonfarm

FROM debian:trixie-slim
# Certificates are for buckets that are reached by TLS.
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates && rm -rf /var/lib/apt/lists/*
RUN useradd --system --uid 10001 --no-create-home photonfarm && install -d -o photonfarm /data
COPY --from=build /photonfarm /usr/local/bin/photonfarm
USER photonfarm
ENV PHOTONFARM_DATA=/data
VOLUME /data
EXPOSE 8080
ENTRYPOINT ["photonfarm"]
CMD ["serve", "--listen", "0.0.0.0:8080"]
