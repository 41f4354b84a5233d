//! A tester with the name of a node that sends nothing in the DBC, as many a DBC has one.

use tests::project;

const DBC: &str = "VERSION \"\"\nNS_ :\nBS_:\nBU_: Body Door Tester\n\
    BO_ 256 Order: 1 Body\n SG_ Open : 0|8@1+ (1,0) [0|1] \"\" Door\n\
    BO_ 257 State: 1 Door\n SG_ Position : 0|8@1+ (1,0) [0|100] \"%\" Body\n";

const DOOR: &str = "name = \"door\"\ntitle = \"\"\ndbc = \"door.dbc\"\nnode = \"Door\"\n\
    [message.State]\nperiod_s = 0.1\n[signal.Position]\nexpression = \"100 * Order.Open\"\n";

const RIG: &str = "[[line]]\nname = \"can0\"\ncan = { dbc = \"../devices/door.dbc\" }\n\
    [[node]]\nname = \"door\"\nat = \"can0\"\nemulate = \"door\"\n\
    [[node]]\nname = \"tester\"\nat = \"can0\"\ntester = true\n";

const PLAN: &str = "name = \"opens\"\ntitle = \"\"\nrig = \"door\"\nsteps = [\n\
    { send = { message = \"Order\", set = { Open = 1 } } },\n\
    { wait_until = { above = { quantity = \"door.Position\", limit = 99 } }, time_limit_s = 1 }]\n\
    [[measurement]]\nname = \"opens\"\ndoc = \"\"\nquantity = \"step.duration\"\nunit = \"s\"\n\
    check = { all_within = [0, 1] }\n";

/// Found by a user: "no tester of this rig sends `Order`".
#[test]
fn it_sends_what_no_other_node_of_the_rig_does() {
    let folder = project::of([
        ("devices/door.dbc", DBC),
        ("devices/door.toml", DOOR),
        ("rigs/door.toml", RIG),
        ("plan.toml", PLAN),
    ]);
    let run = project::load(&folder, "plan.toml").unwrap().run().unwrap();
    assert!(run.passed(), "{run}");
}
