// The roscpp side of the benchmarks: roscpp_bench ROLE [QUEUE] [SECONDS] [SIZE]. The roles are those of node_bench.py.
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Float64.h>
#include <std_srvs/Empty.h>
#include <time.h>

#include <algorithm>
#include <string>
#include <vector>

using std_msgs::Float64;
using sensor_msgs::Image;

static double now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec + t.tv_nsec * 1e-9;
}

static void handleCallbacks(double seconds) {
  ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(seconds));
}

static void ready() {
  std::puts("ready");
  std::fflush(stdout);
}

static void waitForSubscriber(const ros::Publisher& publisher) {
  while (ros::ok() && publisher.getNumSubscribers() == 0) ros::WallDuration(0.01).sleep();
}

static void publishFloats(ros::NodeHandle& node, int queue, double seconds) {
  ros::Publisher publisher = node.advertise<Float64>("bench", queue);
  waitForSubscriber(publisher);
  Float64 message;
  long count = 0;
  const double start = now();
  for (; ros::ok() && now() - start < seconds; ++count) {
    message.data += 0.001;
    publisher.publish(message);
  }
  std::printf("published %.0f /s\n", count / (now() - start));
}

static void publishImages(ros::NodeHandle& node, int queue, double seconds, size_t size) {
  ros::Publisher publisher = node.advertise<Image>("bench_img", queue);
  waitForSubscriber(publisher);
  Image message;
  message.height = 1;
  message.width = message.step = size;
  message.encoding = "mono8";
  message.data.resize(size);
  long count = 0;
  const double start = now();
  for (; ros::ok() && now() - start < seconds; ++count) {
    message.header.stamp = ros::Time::now();
    publisher.publish(message);
    if (size > 100000) ros::WallDuration(0.00005).sleep();
  }
  std::printf("published %.0f /s\n", count / (now() - start));
}

template <class M> void receive(ros::NodeHandle& node, const std::string& topic, int queue, double seconds) {
  long count = 0;
  size_t bytes = 0;
  auto heard = [&](const boost::shared_ptr<M const>& message) {
    ++count;
    bytes += ros::serialization::serializationLength(*message);
  };
  ros::Subscriber subscriber = node.subscribe<M>(topic, queue, boost::function<void(const boost::shared_ptr<M const>&)>(heard),
                                                 ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  ready();
  while (ros::ok() && count == 0) handleCallbacks(0.05);
  const double start = now();
  const long first = count;
  const size_t firstBytes = bytes;
  while (ros::ok() && now() - start < seconds) handleCallbacks(0.05);
  const double took = now() - start;
  std::printf("received %.0f /s  %.1f MB/s\n", (count - first) / took, (bytes - firstBytes) / took / 1e6);
}

static void echo(ros::NodeHandle& node, int queue) {
  ros::Publisher publisher = node.advertise<Float64>("pong", queue);
  ros::Subscriber subscriber = node.subscribe<Float64>(
      "ping", queue, boost::function<void(const Float64::ConstPtr&)>([&](const Float64::ConstPtr& m) { publisher.publish(*m); }),
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  ready();
  ros::spin();
}

static void ping(ros::NodeHandle& node, int queue, double seconds) {
  bool answered = false;
  ros::Publisher publisher = node.advertise<Float64>("ping", queue);
  ros::Subscriber subscriber = node.subscribe<Float64>(
      "pong", queue, boost::function<void(const Float64::ConstPtr&)>([&](const Float64::ConstPtr&) { answered = true; }),
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  waitForSubscriber(publisher);
  while (ros::ok() && subscriber.getNumPublishers() == 0) ros::WallDuration(0.01).sleep();
  std::vector<double> times;
  Float64 message;
  const double start = now();
  while (ros::ok() && now() - start < seconds) {
    const double sent = now();
    answered = false;
    publisher.publish(message);
    while (ros::ok() && !answered && now() - sent < 1) handleCallbacks(0.2);
    if (answered) times.push_back(now() - sent);
    ros::WallDuration(0.0005).sleep();
  }
  std::sort(times.begin(), times.end());
  if (times.empty()) return;
  std::printf("rtt us p50 %.0f p99 %.0f n %zu\n", times[times.size() / 2] * 1e6, times[times.size() * 99 / 100] * 1e6,
              times.size());
}

static bool answer(std_srvs::Empty::Request&, std_srvs::Empty::Response&) { return true; }

static void call(ros::NodeHandle& node, bool persistent, double seconds) {
  ros::service::waitForService("bench_srv");
  ros::ServiceClient client = node.serviceClient<std_srvs::Empty>("bench_srv", persistent);
  std_srvs::Empty exchange;
  long count = 0;
  const double start = now();
  while (ros::ok() && now() - start < seconds) count += client.call(exchange);
  std::printf("calls %.0f /s\n", count / (now() - start));
}

int main(int argc, char** argv) {
  const std::string role = argc > 1 ? argv[1] : "";
  ros::init(argc, argv, "roscpp_" + role, ros::init_options::AnonymousName);
  ros::NodeHandle node;
  const int queue = argc > 2 ? std::atoi(argv[2]) : 1000;
  const double seconds = argc > 3 ? std::atof(argv[3]) : 5;
  const size_t size = argc > 4 ? std::atol(argv[4]) : 0;
  if (role == "pub") publishFloats(node, queue, seconds);
  else if (role == "sub") receive<Float64>(node, "bench", queue, seconds);
  else if (role == "imgpub") publishImages(node, queue, seconds, size);
  else if (role == "imgsub") receive<Image>(node, "bench_img", queue, seconds);
  else if (role == "echo") echo(node, queue);
  else if (role == "ping") ping(node, queue, seconds);
  else if (role == "call") call(node, queue != 0, seconds);
  else if (role == "srv") {
    ros::ServiceServer server = node.advertiseService("bench_srv", answer);
    ready();
    ros::spin();
  } else {
    std::fprintf(stderr, "unknown role\n");
    return 2;
  }
  return 0;
}
