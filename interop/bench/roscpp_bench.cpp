// The roscpp side of the benchmarks: roscpp_bench ROLE KEY=VALUE ...; roles, keys and figures are those of roles.py.
#include <std_srvs/Empty.h>
#include <std_srvs/SetBool.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "roscpp_measuring.hpp"

using std_msgs::Float64;

struct Counter {
  std::atomic<long> count{0};
  std::atomic<double> last{0};

  template <class M> void heard(const boost::shared_ptr<M const>& message) {
    last = read(*message);
    ++count;
  }
  void print(double rate, size_t size) const {
    std::printf("figures rate=%.2f mb=%.2f\n", rate, rate * size / 1e6);
    std::fflush(stdout);
  }
};

template <class M> void pub(ros::NodeHandle& node, const Options& options) {
  ros::Publisher publisher = node.advertise<M>("bench", options.queue());
  M message = filled<M>(options.size());
  ready();
  awaitSubscribers(publisher, options.number("wait", 1));
  const double before = status("VmRSS");
  const double published = tightLoop(options.seconds(), options.size(), [&](long count) {
    change(message, count);
    publisher.publish(message);
  });
  std::printf("figures published=%.2f rss=%.2f\n", published, (status("VmRSS") - before) / 1e3);
  std::fflush(stdout);
}

template <class M> void sub(ros::NodeHandle& node, const Options& options) {
  Counter counter;
  ros::Subscriber subscriber =
      subscribe<M>(node, "bench", options.queue(), [&](const boost::shared_ptr<M const>& m) { counter.heard<M>(m); });
  ready();
  handleFirst([&] { return counter.count.load(); });
  const double start = now();
  const long first = counter.count;
  handleFor(options.seconds());
  counter.print((counter.count - first) / (now() - start), options.size());
}

// Messages within one process, as nodelets exchange them: each a new object, an image with data of its own.
template <class M> void within(ros::NodeHandle& node, const Options& options) {
  Counter counter;
  ros::Subscriber subscriber =
      subscribe<M>(node, "bench", options.queue(), [&](const boost::shared_ptr<M const>& m) { counter.heard<M>(m); });
  ros::Publisher publisher = node.advertise<M>("bench", options.queue());
  M message = filled<M>(options.size());
  ros::AsyncSpinner spinner(1);
  spinner.start();
  awaitSubscribers(publisher, 1);
  std::thread publishing([&] {
    tightLoop(options.seconds() + kSettle + 1, options.size(), [&](long count) {
      change(message, count);
      publisher.publish(boost::make_shared<M>(message));
    });
  });
  while (ros::ok() && counter.count == 0) wait(0.01);
  wait(kSettle);
  const double start = now();
  const long first = counter.count;
  wait(options.seconds());
  counter.print((counter.count - first) / (now() - start), options.size());
  publishing.join();
}

static void echo(ros::NodeHandle& node, const Options& options) {
  ros::Publisher publisher = node.advertise<Float64>("pong", options.queue());
  std::vector<ros::Subscriber> beside;
  double last = 0;
  for (int i = 0; i < options.count(); ++i)
    beside.push_back(subscribe<Float64>(node, "beside" + std::to_string(i), options.queue(),
                                        [&](const Float64::ConstPtr& m) { last = read(*m); }));
  ros::Subscriber subscriber =
      subscribe<Float64>(node, "ping", options.queue(), [&](const Float64::ConstPtr& m) { publisher.publish(*m); });
  ready();
  ros::spin();
}

static void ping(ros::NodeHandle& node, const Options& options) {
  bool answered = false;
  ros::Publisher publisher = node.advertise<Float64>("ping", options.queue());
  ros::Subscriber subscriber =
      subscribe<Float64>(node, "pong", options.queue(), [&](const Float64::ConstPtr&) { answered = true; });
  std::vector<ros::Publisher> beside;
  for (int i = 0; i < options.count(); ++i)
    beside.push_back(node.advertise<Float64>("beside" + std::to_string(i), options.queue()));
  awaitSubscribers(publisher, 1);
  awaitPublisher(subscriber);
  for (const auto& one : beside) awaitSubscribers(one, 1);
  const double end = now() + options.seconds();
  std::thread other([&] {  // all the further topics at 100 Hz from one thread
    Float64 message;
    ros::Rate rate(100);
    while (!beside.empty() && ros::ok() && now() < end) {
      for (auto& one : beside) one.publish(message);
      rate.sleep();
    }
  });
  std::vector<double> times;
  Float64 message;
  while (ros::ok() && now() < end) {
    const double sent = now();
    answered = false;
    publisher.publish(message);
    while (ros::ok() && !answered && now() - sent < 1) handleCallbacks(0.2);
    if (answered) times.push_back(now() - sent);
    wait(0.0005);
  }
  other.join();
  std::printf("figures p50=%.2f p99=%.2f n=%zu\n", share(times, 0.5), share(times, 0.99), times.size());
}

static void rate(ros::NodeHandle& node, const Options& options) {
  ros::Publisher publisher = node.advertise<Float64>("bench", options.queue());
  awaitSubscribers(publisher, 1);
  Float64 message;
  std::vector<double> late;
  ros::Rate rate(1000);
  rate.sleep();
  const double start = now(), used = cpuSeconds();
  for (double last = start; ros::ok() && last - start < options.seconds();) {
    change(message, 0);
    publisher.publish(message);
    rate.sleep();
    const double before = last;
    last = now();
    late.push_back(std::abs(last - before - 0.001));
  }
  const double cpu = (cpuSeconds() - used) / (now() - start) * 100;
  std::printf("figures jitter50=%.2f jitter99=%.2f cpu=%.2f\n", share(late, 0.5), share(late, 0.99), cpu);
}

// Three processes: a sensor at 1 kHz, a controller and an actuator. A message is the time at which it was measured.
static void sense(ros::NodeHandle& node, const Options& options) {
  ros::Publisher publisher = node.advertise<Float64>("sensed", options.queue());
  awaitSubscribers(publisher, 1);
  Float64 message;
  const double cpu = steadyLoop(1000, options.seconds(), [&] {
    message.data = now();
    publisher.publish(message);
  });
  std::printf("figures cpu=%.2f\n", cpu);
}

static void control(ros::NodeHandle& node, const Options& options) {
  ros::Publisher publisher = node.advertise<Float64>("commanded", options.queue());
  awaitSubscribers(publisher, 1);
  long count = 0;
  ros::Subscriber subscriber = subscribe<Float64>(node, "sensed", options.queue(), [&](const Float64::ConstPtr& m) {
    publisher.publish(*m);
    ++count;
  });
  ready();
  handleFirst([&] { return count; });
  const Cpu cpu;
  handleFor(options.seconds());
  std::printf("figures cpu=%.2f\n", cpu.percent());
  std::fflush(stdout);
  ros::spin();
}

static void act(ros::NodeHandle& node, const Options& options) {
  std::vector<double> times;
  ros::Subscriber subscriber = subscribe<Float64>(
      node, "commanded", options.queue(), [&](const Float64::ConstPtr& m) { times.push_back(now() - m->data); });
  ready();
  handleFirst([&] { return times.size(); });
  times.clear();
  const Cpu cpu;
  handleFor(options.seconds());
  const double percent = cpu.percent();
  std::printf("figures p50=%.2f p99=%.2f cpu=%.2f n=%zu\n", share(times, 0.5), share(times, 0.99), percent, times.size());
}

static void beats(ros::NodeHandle& node, const Options& options) {
  std::vector<ros::Publisher> publishers;
  for (int i = 0; i < options.count(); ++i)
    publishers.push_back(node.advertise<Float64>("beat" + std::to_string(i), options.queue()));
  ready();
  for (const auto& one : publishers) awaitSubscribers(one, 1);
  Float64 message;
  size_t next = 0;
  const bool apart = options.number("apart", 0) != 0;
  const double cpu = steadyLoop(apart ? 100 * options.count() : 100, options.seconds(), [&] {
    if (apart) publishers[next++ % publishers.size()].publish(message);
    else for (const auto& one : publishers) one.publish(message);
  });
  std::printf("figures cpu=%.2f\n", cpu);
}

static void hears(ros::NodeHandle& node, const Options& options) {
  long count = 0;
  double last = 0;
  std::vector<ros::Subscriber> subscribers;
  for (int i = 0; i < options.count(); ++i)
    subscribers.push_back(subscribe<Float64>(node, "beat" + std::to_string(i), options.queue(),
                                             [&](const Float64::ConstPtr& m) { last = read(*m), ++count; }));
  ready();
  handleFirst([&] { return count; });
  const long first = count;
  const Cpu cpu;
  handleFor(options.seconds());
  std::printf("figures cpu=%.2f rate=%.2f\n", cpu.percent(), (count - first) / (now() - cpu.start));
}

// x of each transform is the number of its message.
static void tfSends(ros::NodeHandle& node, const Options& options) {
  ros::Publisher publisher = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
  tf2_msgs::TFMessage message = filled<tf2_msgs::TFMessage>(0);
  awaitSubscribers(publisher, 1);
  long count = 0;
  steadyLoop(1000, options.seconds(), [&] {
    ++count;
    for (auto& one : message.transforms) {
      one.header.stamp = ros::Time::now();
      one.transform.translation.x = count;
    }
    publisher.publish(message);
  });
}

static void tfHears(const Options& options) {
  tf2_ros::Buffer buffer;
  tf2_ros::TransformListener listener(buffer, true, ros::TransportHints().tcpNoDelay());
  ready();
  const auto newest = [&] { return buffer.lookupTransform("base_link", "link_19", ros::Time(0)).transform.translation.x; };
  while (ros::ok() && !buffer.canTransform("base_link", "link_19", ros::Time(0))) wait(0.01);
  wait(kSettle);
  const double first = newest(), used = cpuSeconds();
  wait(options.seconds());
  std::printf("figures cpu=%.2f\n", (cpuSeconds() - used) * 1e6 / (newest() - first));
}

template <class S> void call(ros::NodeHandle& node, const Options& options, S exchange) {
  ros::service::waitForService("bench_srv");
  ros::ServiceClient client = node.serviceClient<S>("bench_srv", options.number("persistent", 0) != 0);
  long count = 0;
  const double start = now();
  while (ros::ok() && now() - start < options.seconds()) count += client.call(exchange);
  std::printf("figures rate=%.2f\n", count / (now() - start));
}

static bool answerEmpty(std_srvs::Empty::Request&, std_srvs::Empty::Response&) { return true; }

static bool answerSetBool(std_srvs::SetBool::Request&, std_srvs::SetBool::Response& response) {
  response.success = true;
  response.message = "done";
  return true;
}

static void srv(ros::NodeHandle& node, const Options& options) {
  ros::ServiceServer server = options.text("type") == "SetBool" ? node.advertiseService("bench_srv", answerSetBool)
                                                                : node.advertiseService("bench_srv", answerEmpty);
  ready();
  ros::spin();
}

static void many(ros::NodeHandle& node, const Options& options) {
  std::vector<ros::Publisher> publishers;
  for (int i = 0; i < options.count(); ++i) publishers.push_back(node.advertise<Float64>("idle" + std::to_string(i), 10));
  ready();
  ros::spin();
}

static void idle(ros::NodeHandle& node, const Options& options) {
  std::vector<ros::Subscriber> subscribers;
  double last = 0, before = 0;
  for (int i = 0; i < options.count(); ++i) {
    if (i == 1) {
      awaitPublisher(subscribers[0]);
      before = status("VmRSS");
    }
    subscribers.push_back(subscribe<Float64>(node, "idle" + std::to_string(i), 10,
                                             [&](const Float64::ConstPtr& m) { last = read(*m); }));
  }
  ros::AsyncSpinner spinner(1);
  spinner.start();
  for (const auto& one : subscribers) awaitPublisher(one);
  wait(1);
  const double grown = status("VmRSS") - before, used = cpuSeconds();
  wait(kIdle);
  const double cpu = (cpuSeconds() - used) * 1e3;
  std::printf("figures rss=%.2f threads=%.0f cpu=%.2f\n", grown / (options.count() - 1), status("Threads"), cpu);
}

static void latched(ros::NodeHandle& node) {
  ros::Publisher publisher = node.advertise<Float64>("bench_latched", 1, true);
  publisher.publish(Float64());
  ready();
  ros::spin();
}

static void first(int argc, char** argv) {
  const double start = now();
  ros::init(argc, argv, "first", ros::init_options::AnonymousName);
  ros::NodeHandle node;
  bool heard = false;
  ros::Subscriber subscriber = subscribe<Float64>(node, "bench_latched", 1, [&](const Float64::ConstPtr&) { heard = true; });
  while (ros::ok() && !heard) handleCallbacks(0.2);
  std::printf("figures first=%.2f\n", (now() - start) * 1e3);
}

template <class M> bool play(const std::string& role, ros::NodeHandle& node, const Options& options) {
  if (role == "pub") pub<M>(node, options);
  else if (role == "sub") sub<M>(node, options);
  else if (role == "within") within<M>(node, options);
  else return false;
  return true;
}

static bool playTyped(const std::string& role, ros::NodeHandle& node, const Options& options) {
  const std::string type = options.text("type", "Float64");
  if (type == "Float64") return play<Float64>(role, node, options);
  if (type == "String") return play<std_msgs::String>(role, node, options);
  if (type == "Twist") return play<geometry_msgs::Twist>(role, node, options);
  if (type == "JointState") return play<sensor_msgs::JointState>(role, node, options);
  if (type == "Odometry") return play<nav_msgs::Odometry>(role, node, options);
  if (type == "TFMessage") return play<tf2_msgs::TFMessage>(role, node, options);
  if (type == "Imu") return play<sensor_msgs::Imu>(role, node, options);
  if (type == "LaserScan") return play<sensor_msgs::LaserScan>(role, node, options);
  if (type == "PoseArray") return play<geometry_msgs::PoseArray>(role, node, options);
  if (type == "MarkerArray") return play<visualization_msgs::MarkerArray>(role, node, options);
  if (type == "DiagnosticArray") return play<diagnostic_msgs::DiagnosticArray>(role, node, options);
  if (type == "Image") return play<sensor_msgs::Image>(role, node, options);
  if (type == "PointCloud2") return play<sensor_msgs::PointCloud2>(role, node, options);
  return false;
}

int main(int argc, char** argv) {
  const std::string role = argc > 1 ? argv[1] : "";
  if (role == "first") {
    first(argc, argv);
    return 0;
  }
  ros::init(argc, argv, "bench_" + role, ros::init_options::AnonymousName);
  Options options;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    options.given[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  ros::NodeHandle node;
  if (role == "echo") echo(node, options);
  else if (role == "ping") ping(node, options);
  else if (role == "rate") rate(node, options);
  else if (role == "sense") sense(node, options);
  else if (role == "control") control(node, options);
  else if (role == "act") act(node, options);
  else if (role == "beats") beats(node, options);
  else if (role == "hears") hears(node, options);
  else if (role == "tf_sends") tfSends(node, options);
  else if (role == "tf_hears") tfHears(options);
  else if (role == "srv") srv(node, options);
  else if (role == "call" && options.text("type") == "SetBool") call(node, options, std_srvs::SetBool());
  else if (role == "call") call(node, options, std_srvs::Empty());
  else if (role == "many") many(node, options);
  else if (role == "idle") idle(node, options);
  else if (role == "latched") latched(node);
  else if (!playTyped(role, node, options)) {
    std::fprintf(stderr, "unknown role or type\n");
    return 2;
  }
  return 0;
}
