# docker build -t hunav_drake .
# docker run --rm -v "$PWD/out:/hunav_drake/out" hunav_drake
FROM python:3.12-slim-bookworm
RUN apt-get update && apt-get install -y --no-install-recommends \
    make libglib2.0-0 libegl1 libgl1 libx11-6 graphviz && rm -rf /var/lib/apt/lists/*
WORKDIR /hunav_drake
COPY . .
RUN make .venv/.ready
ENV PATH=/hunav_drake/.venv/bin:$PATH
CMD ["make", "demo"]
