// A program of roslib: calls the ways of rosbridge one after the other, and prints what it saw, as JSON, one per line.
import * as all from 'roslib';
import WebSocket from 'ws';

const ROSLIB = all.Ros ? all : all.default; // version 1 is no module
if (!globalThis.WebSocket) globalThis.WebSocket = WebSocket;
const ros = new ROSLIB.Ros({ url: process.argv[2] });
const say = (name, value) => console.log(JSON.stringify([name, value]));
const within = (promise) =>
  Promise.race([promise, new Promise((_, fail) => setTimeout(() => fail(new Error('too late')), 10000))]);
const ask = (call) => within(new Promise((done, fail) => call(done, (problem) => fail(new Error(String(problem))))));
const ends = [];

let pieces = 0;
const parse = JSON.parse;
JSON.parse = (text) => {
  const value = parse(text);
  pieces += value?.op === 'fragment';
  return value;
};

function first({ fragment_size, ...options }) {
  return within(new Promise((done) => {
    const topic = new ROSLIB.Topic({ ros, ...options });
    if (fragment_size) topic.callForSubscribeAndAdvertise = (message) => ros.callOnConnection({ ...message, fragment_size });
    topic.subscribe((message) => { topic.unsubscribe(); done(message); });
    ends.push(topic);
  }));
}

async function main() {
  await within(new Promise((done, fail) => { ros.on('connection', done); ros.on('error', fail); }));
  say('topics', await ask((done, fail) => ros.getTopics(done, fail)));
  say('type', await ask((done, fail) => ros.getTopicType('/floats', done, fail)));
  say('nodes', await ask((done, fail) => ros.getNodes(done, fail)));
  say('services', await ask((done, fail) => ros.getServices(done, fail)));
  say('service type', await ask((done, fail) => ros.getServiceType('/add', done, fail)));
  say('details', await ask((done, fail) => ros.getMessageDetails('geometry_msgs/Twist', done, fail)));
  const parameter = new ROSLIB.Param({ ros, name: '/web/gain' });
  await ask((done, fail) => parameter.set({ p: 1.5, words: ['a', 'b'] }, done, fail));
  say('param', await ask((done, fail) => parameter.get(done, fail)));

  for (const compression of ['none', 'png', 'cbor']) {
    const message = await first({ name: '/floats', messageType: 'std_msgs/Float64MultiArray', compression });
    say(`floats ${compression}`, Array.from(message.data));
  }
  const image = await first({ name: '/image', messageType: 'sensor_msgs/Image', compression: 'cbor' });
  say('image cbor', [image.height, image.width, image.data.length, image.data[7]]);
  const raw = await first({ name: '/floats', messageType: 'std_msgs/Float64MultiArray', compression: 'cbor-raw' });
  say('floats cbor-raw', raw.bytes.length);

  if (all.Ros) { // version 1 does not put fragments together
    for (const compression of ['none', 'png']) {
      pieces = 0;
      const message = await first({ name: '/floats', messageType: 'std_msgs/Float64MultiArray', compression, fragment_size: 25 });
      say(`fragments of ${compression}`, [message.data, pieces]);
    }
    pieces = 0;
    const answer = within(new Promise((done) => ros.once('pieces', done)));
    ros.callOnConnection({ op: 'call_service', id: 'pieces', service: '/rosapi/nodes', args: {}, fragment_size: 25 });
    say('fragments of an answer', [(await answer).values.nodes.includes('/robot'), pieces]);
  }

  // What comes every 20 ms is throttled; what is sent in fragments is put together.
  const slow = new ROSLIB.Topic({ ros, name: '/fast', messageType: 'std_msgs/Float64', throttle_rate: 300, queue_length: 1 });
  const times = [];
  await within(new Promise((done) => slow.subscribe(() => { times.push(Date.now()); if (times.length === 4) done(); })));
  slow.unsubscribe();
  say('throttled', times.slice(1).map((time, index) => time - times[index]));

  // Of what comes faster than it is throttled, the newest wait, as many as the queue is long.
  const queued = new ROSLIB.Topic({ ros, name: '/echo', messageType: 'std_msgs/String', throttle_rate: 300, queue_length: 2 });
  const burst = new ROSLIB.Topic({ ros, name: '/words', messageType: 'std_msgs/String' });
  const newest = [];
  await within(new Promise((done) => {
    queued.subscribe(({ data }) => {
      if (!newest.length) for (let number = 1; number < 10; number += 1) burst.publish({ data: String(number) });
      newest.push(data);
      if (data === '9') done();
    });
    burst.publish({ data: '0' });
  }));
  queued.unsubscribe();
  say('newest', newest);

  const whole = JSON.stringify({ op: 'publish', topic: '/words', type: 'std_msgs/String', msg: { data: 'in pieces' } });
  const spoken = first({ name: '/echo', messageType: 'std_msgs/String' });
  ros.callOnConnection({ op: 'advertise', topic: '/words', type: 'std_msgs/String' });
  for (let num = 0; num < 3; num += 1) {
    const size = Math.ceil(whole.length / 3);
    ros.callOnConnection({ op: 'fragment', id: 'whole', num, total: 3, data: whole.slice(num * size, (num + 1) * size) });
  }
  say('fragments', (await spoken).data);

  const echo = first({ name: '/echo', messageType: 'std_msgs/String' });
  const words = new ROSLIB.Topic({ ros, name: '/words', messageType: 'std_msgs/String' });
  words.advertise();
  words.publish({ data: 'hello' });
  say('echo', (await echo).data);

  const add = new ROSLIB.Service({ ros, name: '/add', serviceType: 'rospy_tutorials/AddTwoInts' });
  say('sum', await ask((done, fail) => add.callService({ a: 2, b: 40 }, done, fail)));
  say('failure', await ask((done) => add.callService({ a: 'x', b: 40 }, () => done(null), (problem) => done(String(problem)))));

  const provided = new ROSLIB.Service({ ros, name: '/provided', serviceType: 'std_srvs/SetBool' });
  provided.advertise((request, response) => { response.success = !request.data; response.message = 'by roslib'; return true; });
  say('ready', true);
}

main().catch((problem) => { say('problem', String(problem && problem.stack || problem)); process.exit(1); });
