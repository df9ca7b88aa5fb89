from armspan.swarm.director import IN_ZONES, MAKERS, order_name
from armspan.web.views.master import orders


def test_every_behaviour_is_offered_and_those_for_zones_once_for_each():
    found = orders(("pond", "hill"))
    assert len(found) == len(set(found)) == len(MAKERS) + 2 * len(IN_ZONES)
    assert [order_name(order) for order in found] == found
    assert "sweep@hill" in found
