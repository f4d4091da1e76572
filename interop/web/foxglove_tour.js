// Does with the real client what a person does in Foxglove; prints what it saw, as JSON.
// node foxglove_tour.js LINK, with the packages in NODE_PATH; test_foxglove.py runs it.

const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg-serialization");
const { WebSocket } = require("ws");

const socket = new WebSocket(process.argv[2], [FoxgloveClient.SUPPORTED_SUBPROTOCOL], {
  origin: "https://app.foxglove.dev",
});
const client = new FoxgloveClient({ ws: socket });
const channels = new Map();
const services = new Map();
const seen = {};

client.on("advertise", (news) => news.forEach((each) => channels.set(each.topic, each)));
client.on("unadvertise", (ids) =>
  channels.forEach((each, topic) => ids.includes(each.id) && channels.delete(topic)),
);
client.on("advertiseServices", (news) => news.forEach((each) => services.set(each.name, each)));
client.on("error", (error) => fail(error));

function fail(error) {
  console.error(error);
  process.exit(1);
}

function next(event, fits = () => true) {
  return new Promise((resolve) => {
    const listener = (value) => {
      if (fits(value)) {
        client.off(event, listener);
        resolve(value);
      }
    };
    client.on(event, listener);
  });
}

async function until(fits) {
  for (;;) {
    const found = fits();
    if (found) {
      return found;
    }
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

async function message(topic) {
  const channel = await until(() => channels.get(topic));
  const reader = new MessageReader(parse(channel.schema));
  const id = client.subscribe(channel.id);
  const found = await next("message", (each) => each.subscriptionId === id);
  client.unsubscribe(id);
  return { type: channel.schemaName, time: Number(found.timestamp / 1000000000n), value: reader.readMessage(found.data) };
}

async function publish() {
  const definition = "string data";
  const writer = new MessageWriter(parse(definition));
  const about = { topic: "/said", schemaName: "std_msgs/String" };
  const raw = client.advertise({ ...about, encoding: "ros1", schema: definition, schemaEncoding: "ros1msg" });
  client.sendMessage(raw, writer.writeMessage({ data: "from Foxglove" }));
  const json = client.advertise({ ...about, encoding: "json" });
  client.sendMessage(json, new TextEncoder().encode('{"data": "as JSON"}'));
  client.sendMessage(raw, new Uint8Array(2));
  const { level, message: text } = await next("status");
  client.unadvertise(raw);
  client.unadvertise(json);
  return { level, text };
}

async function call(a, b) {
  const service = await until(() => services.get("/add"));
  const request = new MessageWriter(parse(service.request.schema)).writeMessage({ a, b });
  client.sendServiceCallRequest({ serviceId: service.id, callId: 77, encoding: "ros1", data: request });
  const failure = next("serviceCallFailure").then((each) => each.message);
  const response = next("serviceCallResponse").then((each) => {
    const { sum } = new MessageReader(parse(service.response.schema)).readMessage(each.data);
    return [each.callId, Number(sum)];
  });
  return Promise.race([failure, response]);
}

async function parameters() {
  const answers = (id) => next("parameterValues", (each) => each.id === id).then((each) => each.parameters);
  const first = answers("all");
  client.getParameters([], "all");
  const changed = next("parameterValues", (each) => (each.id ?? null) === null && each.parameters[0].value === 3.5);
  client.subscribeParameterUpdates(["/speed"]);
  const second = answers("set");
  client.setParameters([{ name: "/speed", value: 3.5, type: "float64" }], "set");
  return { first: await first, second: await second, changed: (await changed).parameters };
}

async function asset(uri) {
  client.fetchAsset(uri, 5);
  const found = await next("fetchAssetResponse");
  return found.status === 0 ? new TextDecoder().decode(found.data) : found.error;
}

async function tour() {
  seen.info = await next("serverInfo");
  seen.pose = await message("/pose");
  seen.pair = await message("/pair");
  seen.published = await publish();
  seen.sum = await call(3n, 4n);
  seen.failure = await call(-1n, 4n);
  seen.parameters = await parameters();
  client.subscribeConnectionGraph();
  seen.graph = await next("connectionGraphUpdate");
  seen.asset = await asset("package://minimal_nodes/package.xml");
  seen.outside = await asset("package://minimal_nodes/../../__init__.py");
  console.log(JSON.stringify(seen, (_, value) => (typeof value === "bigint" ? Number(value) : value)));
  client.close();
}

tour().catch(fail);
