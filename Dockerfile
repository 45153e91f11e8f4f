# All programs and no C compiler: `export --to fmu` writes the source of a unit alone here.
#
#   docker build --tag seatrial .
#   docker run --rm --user "$(id -u):$(id -g)" --volume "$PWD:/work" seatrial run my-study
#
# Never built yet: see CONTRIBUTING.md.
FROM rust:1-bookworm AS build
WORKDIR /source
COPY . .
RUN cargo build --release --locked -p seatrial-cli \
    && mkdir /programs \
    && find target/release -maxdepth 1 -type f -executable -exec cp {} /programs/ \;

FROM debian:bookworm-slim
COPY --from=build /programs/ /usr/local/bin/
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/seatrial/
WORKDIR /work
USER 1000
ENTRYPOINT ["seatrial"]
CMD ["--help"]
